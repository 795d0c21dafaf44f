// Aligned tables of a campaign.
#include <fmt/format.h>

#include <algorithm>
#include <boost/math/distributions/chi_squared.hpp>
#include <boost/math/distributions/non_central_chi_squared.hpp>
#include <cmath>
#include <map>
#include <set>

#include "tests/blind_trials/bound.h"
#include "tests/blind_trials/campaign.h"

namespace gyrobench::blind_trials {
namespace {

using Outcomes = std::vector<const Outcome*>;

template <class Test>
double Percent(const Outcomes& outcomes, Test test) {
  const auto count = std::ranges::count_if(outcomes, [&](const Outcome* o) { return test(*o); });
  return 100.0 * static_cast<double>(count) / static_cast<double>(outcomes.size());
}

// Wilson's interval of a share, 95 %.
std::array<double, 2> Wilson(double count, double n) {
  constexpr double kZ = 1.96;
  const double p = count / n, z2n = kZ * kZ / n;
  const double middle = p + z2n / 2.0;
  const double half = kZ * std::sqrt((p * (1.0 - p) + z2n / 4.0) / n);
  return {std::max(0.0, (middle - half) / (1.0 + z2n)), (middle + half) / (1.0 + z2n)};
}

struct Estimates {
  double square = 0.0, n = 0.0, covered = 0.0;
  void Add(const Outcome& outcome) {
    for (const auto& error : outcome.errors) {
      const double off = error.estimate - error.truth;
      if (std::isfinite(off / error.bound)) {
        square += std::pow(off / error.bound, 2);
        n += 1.0;
        covered += std::fabs(off) <= 1.96 * error.std_error ? 1.0 : 0.0;
      }
    }
  }
  std::string Text() const {
    if (n == 0.0) return fmt::format("{:>7} {:>7}", "-", "-");
    return fmt::format("{:>7.2f} {:>5.1f} %", std::sqrt(square / n), 100.0 * covered / n);
  }
};

// Whitened RMS after correction on data that the fit did not see: mean and worst of the sets.
struct HeldOutFigures {
  double sum = 0.0, n = 0.0, worst = 0.0;
  void Add(const Outcome& outcome) {
    if (!std::isfinite(outcome.heldout_after)) return;
    sum += outcome.heldout_after;
    worst = std::max(worst, outcome.heldout_after);
    n += 1.0;
  }
  std::string Text() const {
    return n > 0.0 ? fmt::format("{:>8.4f} {:.4f}", sum / n, worst) : fmt::format("{:>16}", "-");
  }
};

// Chance that a normal test sees an effect whose true parameters are `snr` bounds long.
double Power(double snr, int terms, const CampaignOptions& options) {
  const double p = options.false_discovery / options.hypotheses;
  const boost::math::chi_squared central(terms);
  const double limit = boost::math::quantile(boost::math::complement(central, p));
  const double ncp = std::min(snr * snr, 1e4);
  return boost::math::cdf(
      boost::math::complement(boost::math::non_central_chi_squared(terms, ncp), limit));
}

// Visibility of an effect for a unit level, from some of its trials.
std::vector<Visibility> UnitVisibilities(const Outcomes& outcomes, const CampaignOptions& options) {
  std::vector<Visibility> found;
  const auto count =
      std::min<std::size_t>(outcomes.size(), static_cast<std::size_t>(options.bounds));
  for (std::size_t i = 0; i < count; ++i) {
    TrialSpec spec = outcomes[i]->spec;
    HiddenEffect& hidden = spec.effects.front();
    // At a high level what quantisation leaves in the difference does not count.
    hidden.level = kHigh;
    Visibility visibility = VisibilityAtBound(spec);
    visibility.sigmas /= FindInjection(hidden.id).levels[kHigh];
    found.push_back(visibility);
  }
  return found;
}
// Mean over trials, or over effects.
struct PowerFigures {
  double sigmas = 0.0, power = 0.0, n = 0.0;
  void Add(double more_sigmas, double more_power) {
    sigmas += more_sigmas;
    power += more_power;
    n += 1.0;
  }
  void Add(const PowerFigures& mean) {
    if (mean.n > 0.0) Add(mean.sigmas / mean.n, mean.power / mean.n);
  }
  std::string Text() const {
    if (n == 0.0) return fmt::format("{:>7} {:>7}", "-", "-");
    return fmt::format("{:>7.1f} {:>5.1f} %", sigmas / n, 100.0 * power / n);
  }
};
PowerFigures PowerAt(const std::vector<Visibility>& units, double level,
                     const CampaignOptions& options) {
  PowerFigures figures;
  for (const Visibility& unit : units) {
    figures.Add(level * unit.sigmas, Power(level * unit.sigmas, unit.terms, options));
  }
  return figures;
}

constexpr const char* kSingleHead =
    "{:<24} {:<5} {:>5} {:>8} {:>8} {:>8} {:>8} {:>8} {:>8} {:>8} {:>7} {:>7} {:>7} {:>7} {:>16}\n";

std::string SingleHead() {
  std::string text = fmt::format(fmt::runtime(kSingleHead), "effect", "level", "sets", "exact",
                                 "no rival", "among", "wrong", "other", "extra", "nothing",
                                 "sigmas", "power", "err/bnd", "covers", "held out, worst");
  return text;
}

std::string SingleLine(const std::string& name, const char* level, const Outcomes& outcomes,
                       const std::string& power) {
  Estimates estimates;
  HeldOutFigures held_out;
  for (const Outcome* outcome : outcomes) {
    if (outcome->Exact()) estimates.Add(*outcome);
    held_out.Add(*outcome);
  }
  const auto exact = [](const Outcome& o) { return o.Exact(); };
  const auto certain = [](const Outcome& o) { return o.Exact() && !o.AnyRivals(); };
  const auto among = [](const Outcome& o) { return o.TruthAmong(); };
  const auto wrong = [](const Outcome& o) { return o.WrongName(); };
  const auto extra = [](const Outcome& o) { return o.Extra(); };
  const auto nothing = [](const Outcome& o) { return o.winners.empty(); };
  const auto other = [](const Outcome& o) {
    return !o.winners.empty() && !o.TruthAmong() && !o.WrongName();
  };
  return fmt::format(
      "{:<24} {:<5} {:>5} {:>6.1f} % {:>6.1f} % {:>6.1f} % {:>6.1f} % {:>6.1f} % {:>6.1f} % "
      "{:>6.1f} % {} {} {}\n",
      name, level, outcomes.size(), Percent(outcomes, exact), Percent(outcomes, certain),
      Percent(outcomes, among), Percent(outcomes, wrong), Percent(outcomes, other),
      Percent(outcomes, extra), Percent(outcomes, nothing), power, estimates.Text(),
      held_out.Text());
}

std::string SingleTable(const Outcomes& all, const CampaignOptions& options) {
  std::map<std::string, Outcomes> by_id;
  std::map<Level, Outcomes> by_level;
  std::vector<std::string> order;
  for (const Outcome* outcome : all) {
    const HiddenEffect& hidden = outcome->spec.effects.front();
    if (!by_id.contains(hidden.id)) order.push_back(hidden.id);
    by_id[hidden.id].push_back(outcome);
    by_level[hidden.level].push_back(outcome);
  }
  std::string text = SingleHead();
  std::map<Level, PowerFigures> power_of_level;
  for (const std::string& id : order) {
    const std::vector<Visibility> units = UnitVisibilities(by_id[id], options);
    for (const auto& [level, unused] : by_level) {
      Outcomes some;
      std::ranges::copy_if(by_id[id], std::back_inserter(some), [level = level](const Outcome* o) {
        return o->spec.effects.front().level == level;
      });
      if (some.empty()) continue;
      const PowerFigures power = PowerAt(units, FindInjection(id).levels[level], options);
      power_of_level[level].Add(power);
      text += SingleLine(id, kLevelNames[level], some, power.Text());
    }
  }
  for (const auto& [level, some] : by_level) {
    text += SingleLine("all", kLevelNames[level], some, power_of_level[level].Text());
  }
  return text;
}

std::string PairsTable(const Outcomes& all) {
  std::map<Level, Outcomes> by_level;
  for (const Outcome* outcome : all) {
    by_level[outcome->spec.effects.front().level].push_back(outcome);
  }
  std::string text = SingleHead();
  for (const auto& [level, some] : by_level) {
    text += SingleLine("pairs", kLevelNames[level], some, PowerFigures().Text());
  }
  for (const Outcome* outcome : all) {
    if (outcome->Exact()) continue;
    text += fmt::format("  not exact: {}", kLevelNames[outcome->spec.effects.front().level]);
    for (const auto& hidden : outcome->spec.effects) text += " " + hidden.id;
    text += "  named:";
    for (const auto& winner : outcome->winners) text += " " + winner.id;
    text += "\n";
  }
  return text;
}

std::string SilentLine(const std::string& name, const Outcomes& outcomes) {
  double named = 0.0, unexplained = 0.0, n = 0.0;
  HeldOutFigures held_out;
  for (const Outcome* outcome : outcomes) {
    n += 1.0;
    if (!outcome->winners.empty()) named += 1.0;
    if (outcome->winners.empty() && outcome->verdict != calibration::Verdict::kNone) {
      unexplained += 1.0;
    }
    held_out.Add(*outcome);
  }
  const auto interval = Wilson(named, n);
  return fmt::format("{:<24} {:>5.0f} {:>6.0f} {:>6.2f} %  {:>5.2f} .. {:>5.2f} % {:>12.0f} {}\n",
                     name, n, named, 100.0 * named / n, 100.0 * interval[0], 100.0 * interval[1],
                     unexplained, held_out.Text());
}

std::string SilentTable(const Outcomes& all) {
  std::string text =
      fmt::format("{:<24} {:>5} {:>6} {:>8}  {:>16} {:>12} {:>16}\n", "noise", "sets", "named",
                  "share", "95 %", "unexplained", "held out, worst");
  for (std::size_t kind = 0; kind < kNoiseNames.size(); ++kind) {
    Outcomes some;
    std::ranges::copy_if(all, std::back_inserter(some), [kind](const Outcome* o) {
      return static_cast<std::size_t>(o->truth.noise) == kind;
    });
    if (!some.empty()) text += SilentLine(kNoiseNames[kind], some);
  }
  text += SilentLine("all", all);
  for (const Outcome* outcome : all) {
    if (outcome->winners.empty()) continue;
    text += fmt::format("  named in seed {}:", outcome->spec.seed);
    for (const auto& winner : outcome->winners) {
      text += fmt::format(" {} (p = {:.2g})", winner.id, winner.p_value);
    }
    text += "\n";
  }
  return text;
}

Recognition AtBound(const Outcome& outcome) {
  const Recognition how = Recognise(outcome);
  if (how != Recognition::kFalseName) return how;
  const std::set<std::string> copies = CopiesAtBound(outcome.spec);
  const bool all_do_the_same = std::ranges::all_of(outcome.winners, [&](const auto& winner) {
    return !winner.in_catalogue || copies.contains(winner.id);
  });
  return all_do_the_same ? Recognition::kCopy : how;
}

std::string UnknownTable(const Outcomes& all, const CampaignOptions& options) {
  std::map<const Outcome*, Recognition> recognised_as;
  for (const Outcome* outcome : all)
    recognised_as[outcome] = options.bounds > 0 ? AtBound(*outcome) : Recognise(*outcome);
  std::map<std::pair<std::string, Level>, Outcomes> cells;
  for (const Outcome* outcome : all) {
    const HiddenEffect& hidden = outcome->spec.effects.front();
    cells[{hidden.id, hidden.level}].push_back(outcome);
  }
  std::string text = fmt::format("{:<24} {:<5} {:>5}", "hidden", "level", "sets");
  text += fmt::format(" {:>7}", "sigmas");
  for (const char* name : kRecognitionNames) text += fmt::format(" {:>11}", name);
  text += fmt::format(" {:>11}\n", "recognised");
  const auto line = [&](const std::string& name, const char* level, const Outcomes& outcomes,
                        const std::string& sigmas) {
    text += fmt::format("{:<24} {:<5} {:>5} {:>7}", name, level, outcomes.size(), sigmas);
    for (std::size_t kind = 0; kind < kRecognitionNames.size(); ++kind) {
      const auto is = [&](const Outcome& o) {
        return static_cast<std::size_t>(recognised_as.at(&o)) == kind;
      };
      text += fmt::format(" {:>9.1f} %", Percent(outcomes, is));
    }
    const auto recognised = [&](const Outcome& o) {
      const Recognition how = recognised_as.at(&o);
      return how != Recognition::kNone && how != Recognition::kFalseName &&
             how != Recognition::kCopy;
    };
    text += fmt::format(" {:>9.1f} %\n", Percent(outcomes, recognised));
  };
  for (const auto& [key, outcomes] : cells) {
    double sigmas = 0.0;
    const std::vector<Visibility> units = UnitVisibilities(outcomes, options);
    for (const Visibility& unit : units) sigmas += unit.sigmas / static_cast<double>(units.size());
    sigmas *= FindInjection(key.first).levels[key.second];
    line(key.first, kLevelNames[key.second], outcomes,
         units.empty() ? "-" : fmt::format("{:.1f}", sigmas));
  }
  line("all", "", all, "");
  return text;
}

std::string PoorTable(const Outcomes& all) {
  constexpr std::array<const char*, 5> kNames = {"full", "one way", "both ways", "three speeds",
                                                 "at rest"};
  std::map<SequenceKind, Outcomes> by_kind;
  std::set<std::string> ids;
  for (const Outcome* outcome : all) {
    by_kind[outcome->spec.sequence].push_back(outcome);
    ids.insert(outcome->unidentifiable.begin(), outcome->unidentifiable.end());
  }
  std::string text = fmt::format("{:<24}", "listed as unidentifiable");
  for (const auto& [kind, outcomes] : by_kind) {
    text += fmt::format(" {:>12}", kNames[static_cast<std::size_t>(kind)]);
  }
  text += "\n";
  const auto line = [&](const std::string& name, const auto& test) {
    text += fmt::format("{:<24}", name);
    for (const auto& [kind, outcomes] : by_kind) {
      text += fmt::format(" {:>10.1f} %", Percent(outcomes, test));
    }
    text += "\n";
  };
  for (const std::string& id : ids) {
    line(id, [&id](const Outcome& o) {
      return std::ranges::find(o.unidentifiable, id) != o.unidentifiable.end();
    });
  }
  line("(named something)", [](const Outcome& o) { return !o.winners.empty(); });
  return text;
}

}  // namespace

std::string Table(const std::string& kind, const std::vector<Outcome>& outcomes,
                  const CampaignOptions& options) {
  Outcomes traced;
  std::string failures;
  double seconds = 0.0;
  for (const Outcome& outcome : outcomes) {
    seconds += outcome.seconds;
    traced.push_back(&outcome);
    if (outcome.failure.empty()) continue;
    failures += fmt::format("  seed {} failed: {}\n", outcome.spec.seed, outcome.failure);
  }
  std::string text;
  if (!traced.empty()) {
    if (kind == "silent") text = SilentTable(traced);
    if (kind == "single") text = SingleTable(traced, options);
    if (kind == "pairs") text = PairsTable(traced);
    if (kind == "unknown") text = UnknownTable(traced, options);
    if (kind == "poor") text = PoorTable(traced);
  }
  return text + failures +
         fmt::format("{} sets, {:.2f} s of elapsed time each to trace\n", outcomes.size(),
                     seconds / static_cast<double>(std::max<std::size_t>(outcomes.size(), 1)));
}

}  // namespace gyrobench::blind_trials
