#include "tests/blind_trials/outcome.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <exception>
#include <set>

namespace gyrobench::blind_trials {
namespace {

using calibration::TracedEffect;

std::set<std::string> Hidden(const Outcome& outcome) {
  std::set<std::string> ids;
  for (const auto& effect : outcome.truth.effects) ids.insert(effect.id);
  return ids;
}
std::set<std::string> Named(const Outcome& outcome) {
  std::set<std::string> ids;
  for (const auto& winner : outcome.winners) ids.insert(winner.id);
  return ids;
}
std::set<std::string> NamedOrRival(const Outcome& outcome) {
  std::set<std::string> ids = Named(outcome);
  for (const auto& winner : outcome.winners) ids.insert(winner.rivals.begin(), winner.rivals.end());
  return ids;
}
bool Includes(const std::set<std::string>& all, const std::set<std::string>& some) {
  return std::ranges::includes(all, some);
}

// The traced parameters of these names as one: their length where there are several.
bool Combined(const TracedEffect& traced, const TrueParameter& truth, Outcome::Error& error) {
  double value = 0.0, variance = 0.0, bound = 0.0;
  for (const std::string& name : truth.names) {
    // Those of an axis of the stand carry its name: b_inner.
    const auto found = std::ranges::find_if(traced.parameters, [&](const auto& parameter) {
      return parameter.name == name || parameter.name.starts_with(name + "_");
    });
    if (found == traced.parameters.end()) return false;
    value = std::hypot(value, found->value);
    variance += std::pow(found->value * found->std_error, 2);
    bound += std::pow(found->value * found->bound, 2);
    if (truth.names.size() > 1) continue;
    error.estimate = truth.signless ? std::fabs(found->value) : found->value;
    error.std_error = found->std_error;
    error.bound = found->bound;
  }
  if (truth.names.size() > 1) {
    error.estimate = value;
    error.std_error = std::sqrt(variance) / value;
    error.bound = std::sqrt(bound) / value;
  }
  return true;
}

void CompareParameters(const TracedEffect& traced, const TrialTruth& truth, Outcome& outcome) {
  const auto hidden = std::ranges::find(truth.effects, traced.id, &TrialTruth::Effect::id);
  if (hidden == truth.effects.end()) return;
  for (const TrueParameter& parameter : hidden->parameters) {
    Outcome::Error error;
    error.id = traced.id;
    error.name = parameter.names.front();
    error.truth = parameter.signless ? std::fabs(parameter.value) : parameter.value;
    if (Combined(traced, parameter, error)) outcome.errors.push_back(error);
  }
}

void TakeVerdict(const calibration::ChannelTrace& channel, Outcome& outcome) {
  outcome.verdict = channel.verdict;
  outcome.heldout_before = channel.heldout_whitened_rms.before;
  outcome.heldout_after = channel.heldout_whitened_rms.after;
  for (const auto& item : channel.unidentifiable) outcome.unidentifiable.push_back(item.id);
  for (const TracedEffect& effect : channel.effects) {
    Outcome::Winner winner;
    winner.id = effect.id;
    winner.in_catalogue = effect.origin == calibration::EffectOrigin::kCatalogue;
    winner.empirical = effect.origin == calibration::EffectOrigin::kEmpirical;
    winner.rivals = effect.rivals;
    winner.p_value = effect.p_value;
    outcome.winners.push_back(winner);
    CompareParameters(effect, outcome.truth, outcome);
  }
}

using Clock = std::chrono::steady_clock;

}  // namespace

bool Outcome::Exact() const { return failure.empty() && Named(*this) == Hidden(*this); }
bool Outcome::AnyRivals() const {
  return std::ranges::any_of(winners, [](const Winner& w) { return !w.rivals.empty(); });
}
bool Outcome::TruthAmong() const { return Includes(NamedOrRival(*this), Hidden(*this)); }
bool Outcome::WrongName() const {
  const std::set<std::string> hidden = Hidden(*this);
  if (TruthAmong()) return false;
  return std::ranges::any_of(winners, [&](const Winner& winner) {
    if (!winner.in_catalogue || hidden.contains(winner.id)) return false;
    return std::ranges::none_of(winner.rivals,
                                [&](const std::string& id) { return hidden.contains(id); });
  });
}
bool Outcome::Extra() const { return Includes(Named(*this), Hidden(*this)) && !Exact(); }

Outcome RunTrial(const TrialSpec& spec, std::uint64_t trace_seed) {
  Outcome outcome;
  outcome.spec = spec;
  calibration::Collector collector;
  outcome.truth = RecordTrial(spec, collector);
  const calibration::Recording recording = collector.Take();
  const calibration::Recording* const recordings[] = {&recording};
  const Clock::time_point begin = Clock::now();
  try {
    calibration::TraceOptions options;
    options.seed = trace_seed;
    options.curves = false;
    const calibration::Traced traced = calibration::Trace(recordings, options);
    for (const calibration::ChannelTrace& channel : traced.result.channels) {
      if (channel.axis == SensorAxis::kZ) TakeVerdict(channel, outcome);
    }
  } catch (const std::exception& error) {
    outcome.failure = error.what();
  }
  outcome.seconds = std::chrono::duration<double>(Clock::now() - begin).count();
  return outcome;
}

bool NamesFalsely(const Outcome& outcome) {
  std::set<std::string> right;
  for (const auto& hidden : outcome.truth.effects) {
    const auto& ids = FindInjection(hidden.id).right_ids;
    right.insert(ids.begin(), ids.end());
  }
  const auto in_doubt = [&](const std::string& rival) {
    return right.contains(rival) || rival.starts_with("composed") || rival.starts_with("empirical");
  };
  return std::ranges::any_of(outcome.winners, [&](const Outcome::Winner& winner) {
    return winner.in_catalogue && !right.contains(winner.id) &&
           std::ranges::none_of(winner.rivals, in_doubt);
  });
}

Recognition Recognise(const Outcome& outcome) {
  const auto& winners = outcome.winners;
  const bool structure_remains = outcome.verdict == calibration::Verdict::kUnexplained ||
                                 outcome.verdict == calibration::Verdict::kPartlyExplained;
  if (winners.empty()) return structure_remains ? Recognition::kUnexplained : Recognition::kNone;
  if (NamesFalsely(outcome)) return Recognition::kFalseName;
  for (const auto& hidden : outcome.truth.effects) {
    const auto& right = FindInjection(hidden.id).right_ids;
    const auto is_right = [&](const auto& w) {
      return std::ranges::find(right, w.id) != right.end();
    };
    if (std::ranges::any_of(winners, is_right)) return Recognition::kRightName;
  }
  if (std::ranges::any_of(winners, [](const auto& w) { return !w.in_catalogue && !w.empirical; })) {
    return Recognition::kComposed;
  }
  if (std::ranges::any_of(winners, &Outcome::Winner::empirical)) return Recognition::kEmpirical;
  return Recognition::kRival;
}

}  // namespace gyrobench::blind_trials
