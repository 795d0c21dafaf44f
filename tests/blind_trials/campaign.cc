#include "tests/blind_trials/campaign.h"

#include <fmt/format.h>

#include <atomic>
#include <mutex>
#include <nlohmann/json.hpp>
#include <thread>

#include "base/error.h"
#include "stand/random.h"

namespace gyrobench::blind_trials {
namespace {

using Ids = std::vector<std::string>;

Ids IdsOf(const std::vector<Injection>& injections, const CampaignOptions& options) {
  Ids ids;
  for (const Injection& injection : injections) {
    const bool wanted = options.effects.empty() ||
                        std::ranges::find(options.effects, injection.id) != options.effects.end();
    if (wanted) ids.push_back(injection.id);
  }
  return ids;
}

void PlanSingles(const Ids& ids, const CampaignOptions& options, std::vector<TrialSpec>& specs) {
  for (const std::string& id : ids) {
    for (const Level level : options.levels) {
      for (int i = 0; i < options.sets; ++i) specs.push_back({.effects = {{id, level}}});
    }
  }
}

void PlanPairs(const Ids& ids, const CampaignOptions& options, std::vector<TrialSpec>& specs) {
  if (ids.size() < 2) throw DataError("pairs need two effects of the catalogue at least");
  std::mt19937_64 random(options.seed);
  for (const Level level : options.levels) {
    if (level == kLow) continue;
    for (int i = 0; i < options.sets; ++i) {
      const std::size_t first = random() % ids.size();
      const std::size_t second = (first + 1 + random() % (ids.size() - 1)) % ids.size();
      specs.push_back({.effects = {{ids[first], level}, {ids[second], level}}});
    }
  }
}

void PlanPoor(const CampaignOptions& options, std::vector<TrialSpec>& specs) {
  for (const SequenceKind kind : {SequenceKind::kOneWay, SequenceKind::kBothWays,
                                  SequenceKind::kThreeSpeeds, SequenceKind::kFull}) {
    for (int i = 0; i < options.sets; ++i) specs.push_back({.sequence = kind});
  }
}

nlohmann::json Number(double value) {
  return std::isfinite(value) ? nlohmann::json(value) : nlohmann::json(nullptr);
}

nlohmann::json ToJson(const Outcome& outcome) {
  nlohmann::json hidden = nlohmann::json::array(), named = hidden, errors = hidden;
  for (const HiddenEffect& effect : outcome.spec.effects) {
    hidden.push_back({{"id", effect.id}, {"level", kLevelNames[effect.level]}});
  }
  for (const auto& winner : outcome.winners) {
    named.push_back({{"id", winner.id},
                     {"origin", winner.in_catalogue ? "catalogue"
                                : winner.empirical  ? "empirical"
                                                    : "composed"},
                     {"rivals", winner.rivals},
                     {"p_value", Number(winner.p_value)}});
  }
  for (const auto& error : outcome.errors) {
    errors.push_back({{"id", error.id},
                      {"name", error.name},
                      {"truth", Number(error.truth)},
                      {"estimate", Number(error.estimate)},
                      {"std_error", Number(error.std_error)},
                      {"bound", Number(error.bound)}});
  }
  return {{"seed", outcome.spec.seed},
          {"sequence", static_cast<int>(outcome.spec.sequence)},
          {"noise", kNoiseNames[static_cast<std::size_t>(outcome.truth.noise)]},
          {"supply_recorded", outcome.truth.supply_recorded},
          {"hidden", hidden},
          {"verdict", calibration::Name(outcome.verdict)},
          {"named", named},
          {"unidentifiable", outcome.unidentifiable},
          {"parameters", errors},
          {"heldout_whitened_rms",
           {{"before", Number(outcome.heldout_before)}, {"after", Number(outcome.heldout_after)}}},
          {"trace_s", outcome.seconds},
          {"failure", outcome.failure}};
}

}  // namespace

std::vector<TrialSpec> PlanTrials(const std::string& kind, const CampaignOptions& options) {
  std::vector<TrialSpec> specs;
  if (kind == "silent") {
    specs.resize(static_cast<std::size_t>(options.silent_sets));
  } else if (kind == "single") {
    PlanSingles(IdsOf(CatalogueInjections(), options), options, specs);
  } else if (kind == "pairs") {
    PlanPairs(IdsOf(CatalogueInjections(), options), options, specs);
  } else if (kind == "unknown") {
    PlanSingles(IdsOf(UnknownInjections(), options), options, specs);
  } else if (kind == "poor") {
    PlanPoor(options, specs);
  } else {
    throw DataError(
        fmt::format("kind '{}': expected silent, single, pairs, unknown or poor", kind));
  }
  stand::SplitMix64 seeds(stand::Mix(options.seed) ^ std::hash<std::string>{}(kind));
  for (TrialSpec& spec : specs) spec.seed = seeds();
  return specs;
}

std::vector<Outcome> RunTrials(const std::vector<TrialSpec>& specs, int jobs,
                               const std::function<void(std::size_t done)>& done) {
  std::vector<Outcome> outcomes(specs.size());
  std::atomic<std::size_t> next = 0;
  std::size_t finished = 0;
  std::mutex mutex;
  const auto work = [&] {
    for (std::size_t i = next++; i < specs.size(); i = next++) {
      outcomes[i] = RunTrial(specs[i]);
      const std::lock_guard lock(mutex);
      done(++finished);
    }
  };
  std::vector<std::jthread> threads;
  for (int i = 1; i < jobs; ++i) threads.emplace_back(work);
  work();
  threads.clear();
  return outcomes;
}

std::string JsonLines(const std::vector<Outcome>& outcomes) {
  std::string text;
  for (const Outcome& outcome : outcomes) text += ToJson(outcome).dump() + "\n";
  return text;
}

}  // namespace gyrobench::blind_trials
