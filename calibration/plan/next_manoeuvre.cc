#include "calibration/plan/next_manoeuvre.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <set>
#include <utility>

#include "base/error.h"
#include "calibration/plan/channel_outlook.h"

namespace gyrobench::calibration {
namespace {

constexpr double kDecided_nats = 8.0;
// Where the trace itself tells the two apart, which it does beyond 10 of its BIC, these are enough.
constexpr double kTold_nats = 5.0;
// Less than this a minute is no reason to go on.
constexpr double kLeast_nats_per_min = 0.05;
constexpr std::size_t kMostReasons = 3;
// What the best manoeuvre, made again and again, would not settle in this time is closed.
constexpr double kPatience_min = 30.0;
// So much was expected of what was made for a pair that is still open: it is closed.
constexpr double kAsked_nats = 2.0 * kDecided_nats;
// Of a pair that should have been told apart by what was measured, and was not: counted so for
// each further manoeuvre.
constexpr double kOverdue_nats = kAsked_nats / 4.0;
// How likely an effect of the catalogue is to be in a part before anything is known of it. What
// would be known of it counts so much beside what would be told apart of what is named. Of the 23
// effects of the catalogue a typical part (config/scenarios/typical.toml) has five.
constexpr double kPrior = 0.2;

struct Reason {
  std::string what;
  double nats = 0.0;
};

std::string Join(std::vector<Reason> reasons) {
  std::stable_sort(reasons.begin(), reasons.end(),
                   [](const Reason& a, const Reason& b) { return a.nats > b.nats; });
  std::vector<std::string> names;
  for (const Reason& reason : reasons) {
    if (names.size() == kMostReasons || reason.nats < 0.1 * reasons.front().nats) break;
    if (std::find(names.begin(), names.end(), reason.what) == names.end())
      names.push_back(reason.what);
  }
  return fmt::format("{}", fmt::join(names, ", "));
}

class Chooser {
 public:
  Chooser(const Recording& so_far, const Traced& traced, std::span<const Manoeuvre> menu,
          LoopMemory& memory, double small_below)
      : menu_(menu), memory_(memory) {
    const Vector3 rough = RoughSensitivity(so_far);
    std::vector<Recording> recordings;
    recordings.reserve(menu.size());
    Vector3 units = rough;
    for (const ChannelModel& model : traced.models) {
      double& unit = units[static_cast<std::size_t>(model.axis)];
      if (!std::isfinite(unit)) unit = model.units_per_deg_s;
    }
    std::vector<StateHistory> histories;
    histories.push_back(MakeStateHistory(so_far, rough, true, {}));
    for (const Manoeuvre& manoeuvre : menu) {
      recordings.push_back(Foresee(manoeuvre, so_far, units));
      histories.push_back(MakeStateHistory(recordings.back(), units, false, {}));
    }
    FindSmall(traced.result, small_below);
    for (std::size_t i = 0; i < traced.models.size(); ++i) {
      const ChannelTrace& channel = traced.result.channels[i];
      const std::string axis = Axis(channel);
      std::set<std::string> judged;
      if (IsKnown(channel.noise)) {
        outlooks_.emplace_back(histories, traced.models[i], channel.noise);
        for (auto& rivalry : outlooks_.back().Rivalries())
          rivalries_.push_back({axis, std::move(rivalry)});
        judged = outlooks_.back().Judged();
      }
      AddNamed(axis, channel, judged);
    }
  }

  NextManoeuvre Choose() {
    NextManoeuvre out;
    std::set<std::string> closed, newly_closed;
    // Whether the pair is closed, by now or by `hopeless`.
    const auto close = [&](const std::string& pair, bool hopeless) {
      if (!hopeless && !memory_.closed.contains(pair) && memory_.asked_nats[pair] < kAsked_nats)
        return false;
      closed.insert(pair);
      if (memory_.closed.insert(pair).second) newly_closed.insert(pair);
      return true;
    };
    std::erase_if(rivalries_, [&](const AxisRivalry& one) {
      const std::string pair = Pair(one.axis, one.rivalry.named, one.rivalry.other);
      const bool told = std::find(not_told_.begin(), not_told_.end(), pair) == not_told_.end();
      if (one.rivalry.now >= (told ? kTold_nats : kDecided_nats)) return true;
      if (IsSmall(one.axis, one.rivalry.named)) {
        small_pairs_.insert(pair);
        return true;
      }
      if (close(pair, Hopeless(one.rivalry))) return true;
      open_.insert(pair);
      return false;
    });
    // What the data do not tell apart yet, whatever was to be expected.
    std::set<std::string> overdue;
    for (const std::string& pair : not_told_) {
      if (small_pairs_.contains(pair) || close(pair, false)) continue;
      if (open_.insert(pair).second) overdue.insert(pair);
    }
    out.small = small_;
    out.small_pairs = fmt::format("{}", fmt::join(small_pairs_, "; "));
    out.never = fmt::format("{}", fmt::join(closed, "; "));
    out.newly_closed = fmt::format("{}", fmt::join(newly_closed, "; "));
    out.settled = any_named_ && open_.empty();
    out.open = any_named_ ? fmt::format("{}", fmt::join(open_, "; "))
                          : "whether there is anything beyond the baseline";
    for (const ChannelOutlook& outlook : outlooks_) {
      for (auto& known : outlook.KnowledgeOfAll()) knowledge_.push_back(std::move(known));
    }
    for (std::size_t m = 0; m < menu_.size(); ++m) out.worths.push_back(OfBoth(m));
    out.best = Best(out.worths);
    if (out.best) Remember(*out.best, overdue);
    return out;
  }

 private:
  struct AxisRivalry {
    std::string axis;
    ChannelOutlook::Rivalry rivalry;
  };

  static bool IsKnown(const NoiseModel& noise) {
    return std::isfinite(noise.angle_random_walk_deg_sqrt_s) &&
           std::isfinite(noise.bias_random_walk_deg_s_sqrt_s) &&
           std::isfinite(noise.reference_deg) && noise.angle_random_walk_deg_sqrt_s > 0.0;
  }

  static std::string Pair(const std::string& axis, const std::string& named,
                          const std::string& other) {
    return fmt::format("{}: {} or {}", axis, named, other);
  }

  static std::string Axis(const ChannelTrace& channel) {
    return std::string(1, "xyz"[static_cast<std::size_t>(channel.axis)]);
  }

  // Where all are small, none is: they are what there is to be told.
  void FindSmall(const TraceResult& result, double small_below) {
    std::set<std::pair<std::string, std::string>> large;
    for (const ChannelTrace& channel : result.channels) {
      for (const TracedEffect& effect : channel.effects) {
        const bool small = ShareOfError(effect) < small_below;
        (small ? small_ : large).insert({Axis(channel), effect.id});
      }
    }
    if (large.empty()) small_.clear();
    for (const auto& one : large) small_.erase(one);
  }
  bool IsSmall(const std::string& axis, const std::string& id) const {
    return small_.contains({axis, id});
  }

  void AddNamed(const std::string& axis, const ChannelTrace& channel,
                const std::set<std::string>& judged) {
    for (const TracedEffect& effect : channel.effects) {
      any_named_ = true;
      const bool small = IsSmall(axis, effect.id);
      if (!judged.contains(effect.id)) {
        (small ? small_pairs_ : open_)
            .insert(fmt::format("{}: what is behind {}", axis, effect.id));
      }
      for (const std::string& rival : effect.rivals) {
        const std::string pair = Pair(axis, effect.id, rival);
        not_told_.push_back(pair);
        if (small) small_pairs_.insert(pair);
      }
    }
  }

  double Minutes(std::size_t m) const { return std::max(menu_[m].duration_s / 60.0, 1e-3); }

  // Of what is expected of this choice, for the pairs that are open.
  void Remember(std::size_t chosen, const std::set<std::string>& overdue) {
    for (const AxisRivalry& one : rivalries_) {
      memory_.asked_nats[Pair(one.axis, one.rivalry.named, one.rivalry.other)] +=
          std::max(0.0, GainOf(one.rivalry, chosen));
    }
    for (const std::string& pair : overdue) memory_.asked_nats[pair] += kOverdue_nats;
  }

  static double GainOf(const ChannelOutlook::Rivalry& rivalry, std::size_t m) {
    return std::min(rivalry.then[m], kDecided_nats) - rivalry.now;
  }

  bool Hopeless(const ChannelOutlook::Rivalry& rivalry) const {
    if (menu_.empty()) return false;
    double most = 0.0;  // nats a minute
    for (std::size_t m = 0; m < menu_.size(); ++m)
      most = std::max(most, (rivalry.then[m] - rivalry.now) / Minutes(m));
    return kDecided_nats - rivalry.now > std::min(kPatience_min, memory_.left_min) * most;
  }

  ManoeuvreWorth Worth(std::size_t m, const std::vector<Reason>& reasons, const char* verb) const {
    ManoeuvreWorth worth;
    for (const Reason& reason : reasons) worth.nats += reason.nats;
    worth.nats_per_min = worth.nats / Minutes(m);
    if (!reasons.empty()) worth.because = fmt::format("{} {}", verb, Join(reasons));
    return worth;
  }

  ManoeuvreWorth OfRivalries(std::size_t m) const {
    std::vector<Reason> reasons;
    for (const AxisRivalry& one : rivalries_) {
      const double gain = GainOf(one.rivalry, m);
      if (gain > 0.0)
        reasons.push_back({fmt::format("{} from {}", one.rivalry.named, one.rivalry.other), gain});
    }
    return Worth(m, reasons, "tells");
  }

  ManoeuvreWorth OfKnowledge(std::size_t m, double weight) const {
    std::vector<Reason> reasons;
    for (const auto& known : knowledge_) {
      const double gain = weight * (known.then[m] - known.now);
      if (gain > 0.0) reasons.push_back({known.id, gain});
    }
    return Worth(m, reasons, "would show");
  }

  // In the words of the larger part.
  ManoeuvreWorth OfBoth(std::size_t m) const {
    if (rivalries_.empty()) return OfKnowledge(m, 1.0);
    const ManoeuvreWorth told = OfRivalries(m), shown = OfKnowledge(m, kPrior);
    ManoeuvreWorth both = told.nats >= shown.nats ? told : shown;
    both.nats = told.nats + shown.nats;
    both.nats_per_min = both.nats / Minutes(m);
    return both;
  }

  std::optional<std::size_t> Best(const std::vector<ManoeuvreWorth>& worths) const {
    std::optional<std::size_t> best;
    double most = kLeast_nats_per_min;
    for (std::size_t m = 0; m < worths.size(); ++m) {
      if (!menu_[m].affordable || !(worths[m].nats_per_min > most)) continue;
      most = worths[m].nats_per_min;
      best = m;
    }
    return best;
  }

  std::span<const Manoeuvre> menu_;
  LoopMemory& memory_;
  std::vector<ChannelOutlook> outlooks_;
  std::vector<AxisRivalry> rivalries_;
  std::vector<ChannelOutlook::Knowledge> knowledge_;
  std::vector<std::string> not_told_;  // pairs, by the trace
  std::set<std::string> open_, small_pairs_;
  std::set<std::pair<std::string, std::string>> small_;  // axis, effect
  bool any_named_ = false;
};

}  // namespace

NextManoeuvre ChooseManoeuvre(const Recording& so_far, const Traced& traced,
                              std::span<const Manoeuvre> menu) {
  LoopMemory memory;
  return ChooseManoeuvre(so_far, traced, menu, memory);
}

NextManoeuvre ChooseManoeuvre(const Recording& so_far, const Traced& traced,
                              std::span<const Manoeuvre> menu, LoopMemory& memory,
                              double small_below) {
  if (so_far.info.reference != ReferenceKind::kStandAngles) {
    throw DataError(
        fmt::format("{}: manoeuvres are chosen for the angles of a stand; this "
                    "measurement has another reference",
                    so_far.info.source));
  }
  return Chooser(so_far, traced, menu, memory, small_below).Choose();
}

}  // namespace gyrobench::calibration
