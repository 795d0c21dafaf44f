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
// Less than this a minute is no reason to go on.
constexpr double kLeast_nats_per_min = 0.05;
constexpr std::size_t kMostReasons = 3;
// What the best manoeuvre, made again and again, would not settle in this time is left open.
constexpr double kPatience_min = 30.0;

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
  Chooser(const Recording& so_far, const Traced& traced, std::span<const Manoeuvre> menu)
      : menu_(menu) {
    const Vector3 rough = RoughSensitivity(so_far);
    std::vector<Recording> recordings;
    recordings.reserve(menu.size());
    Vector3 units = rough;
    for (const ChannelModel& model : traced.models) {
      double& unit = units[static_cast<std::size_t>(model.axis)];
      if (!std::isfinite(unit)) unit = model.units_per_deg_s;
    }
    std::vector<Trail> trails;
    trails.push_back(MakeTrail(so_far, rough, true, {}));
    for (const Manoeuvre& manoeuvre : menu) {
      recordings.push_back(Foresee(manoeuvre, so_far, units));
      trails.push_back(MakeTrail(recordings.back(), units, false, {}));
    }
    for (std::size_t i = 0; i < traced.models.size(); ++i) {
      const TraceNoise& noise = traced.result.channels[i].noise;
      if (!std::isfinite(noise.angle_random_walk_deg_sqrt_s)) continue;
      const ChannelOutlook outlook(trails, traced.models[i], noise);
      for (auto& rivalry : outlook.Rivalries()) rivalries_.push_back(std::move(rivalry));
      for (auto& known : outlook.KnowledgeOfAll()) knowledge_.push_back(std::move(known));
    }
    for (const ChannelTrace& channel : traced.result.channels) {
      for (const TracedEffect& effect : channel.effects) {
        any_named_ = true;
        if (effect.origin != EffectOrigin::kCatalogue)
          open_.insert(fmt::format("what is behind {}", effect.id));
        for (const std::string& rival : effect.rivals) not_told_.emplace_back(effect.id, rival);
      }
    }
  }

  NextManoeuvre Choose() {
    NextManoeuvre out;
    std::set<std::string> hopeless;
    std::erase_if(rivalries_, [&](const auto& rivalry) {
      const bool decided = rivalry.now >= kDecided_nats;
      const bool never = !decided && Hopeless(rivalry);
      if (never) hopeless.insert(Pair(rivalry.named, rivalry.other));
      return decided || never;
    });
    for (const auto& rivalry : rivalries_) open_.insert(Pair(rivalry.named, rivalry.other));
    // What the data do not tell apart yet, whatever was to be expected.
    for (const auto& [named, rival] : not_told_) {
      if (!hopeless.contains(Pair(named, rival))) open_.insert(Pair(named, rival));
    }
    out.never = fmt::format("{}", fmt::join(hopeless, "; "));
    out.settled = any_named_ && open_.empty();
    out.open = any_named_ ? fmt::format("{}", fmt::join(open_, "; "))
                          : "whether there is anything beyond the baseline";
    for (std::size_t m = 0; m < menu_.size(); ++m) out.worths.push_back(OfRivalries(m));
    out.best = Best(out.worths);
    if (out.best) return out;
    for (std::size_t m = 0; m < menu_.size(); ++m) out.worths[m] = OfKnowledge(m);
    out.best = Best(out.worths);
    return out;
  }

 private:
  static std::string Pair(const std::string& named, const std::string& other) {
    return fmt::format("{} or {}", named, other);
  }

  bool Hopeless(const ChannelOutlook::Rivalry& rivalry) const {
    double most = 0.0;  // nats a minute
    for (std::size_t m = 0; m < menu_.size(); ++m) {
      most = std::max(most, (rivalry.then[m] - rivalry.now) / (menu_[m].duration_s / 60.0));
    }
    return kDecided_nats - rivalry.now > kPatience_min * most;
  }

  ManoeuvreWorth Worth(std::size_t m, const std::vector<Reason>& reasons, const char* verb) const {
    ManoeuvreWorth worth;
    for (const Reason& reason : reasons) worth.nats += reason.nats;
    worth.nats_per_min = worth.nats / std::max(menu_[m].duration_s / 60.0, 1e-3);
    if (!reasons.empty()) worth.because = fmt::format("{} {}", verb, Join(reasons));
    return worth;
  }

  ManoeuvreWorth OfRivalries(std::size_t m) const {
    std::vector<Reason> reasons;
    for (const auto& rivalry : rivalries_) {
      const double gain = std::min(rivalry.then[m], kDecided_nats) - rivalry.now;
      if (rivalry.now < kDecided_nats && gain > 0.0)
        reasons.push_back({fmt::format("{} from {}", rivalry.named, rivalry.other), gain});
    }
    return Worth(m, reasons, "tells");
  }

  ManoeuvreWorth OfKnowledge(std::size_t m) const {
    std::vector<Reason> reasons;
    for (const auto& known : knowledge_) {
      const double gain = known.then[m] - known.now;
      if (gain > 0.0) reasons.push_back({known.id, gain});
    }
    return Worth(m, reasons, "would show");
  }

  static std::optional<std::size_t> Best(const std::vector<ManoeuvreWorth>& worths) {
    std::optional<std::size_t> best;
    double most = kLeast_nats_per_min;
    for (std::size_t m = 0; m < worths.size(); ++m) {
      if (!(worths[m].nats_per_min > most)) continue;
      most = worths[m].nats_per_min;
      best = m;
    }
    return best;
  }

  std::span<const Manoeuvre> menu_;
  std::vector<ChannelOutlook::Rivalry> rivalries_;
  std::vector<ChannelOutlook::Knowledge> knowledge_;
  std::vector<std::pair<std::string, std::string>> not_told_;  // by the trace
  std::set<std::string> open_;
  bool any_named_ = false;
};

}  // namespace

NextManoeuvre ChooseManoeuvre(const Recording& so_far, const Traced& traced,
                              std::span<const Manoeuvre> menu) {
  if (so_far.info.reference != ReferenceKind::kStandAngles) {
    throw DataError(
        fmt::format("{}: manoeuvres are chosen for the angles of a stand; this "
                    "measurement has another reference",
                    so_far.info.source));
  }
  return Chooser(so_far, traced, menu).Choose();
}

}  // namespace gyrobench::calibration
