// Which trials are run, and what is made of them.
#pragma once

#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "tests/blind_trials/outcome.h"

namespace gyrobench::blind_trials {

struct CampaignOptions {
  int sets = 20;  // of each effect and level, of each level of pairs, of each poor sequence
  int silent_sets = 500;
  std::uint64_t seed = 1;
  int jobs = 1;
  std::vector<std::string> effects;  // ids; empty: all of the kind
  std::vector<Level> levels = {kLow, kMid, kHigh};
  // For the power that the bound permits: chance of a false name, and among how many hypotheses.
  double false_discovery = 0.003;
  int hypotheses = 300;
  int bounds = 4;  // sets of each effect from which it is computed
};

// Trials of one kind: silent, single, pairs, unknown, poor. Their seeds are scrambled numbers that
// do not tell what is hidden. Throws DataError for another kind.
std::vector<TrialSpec> PlanTrials(const std::string& kind, const CampaignOptions& options);

// Runs them in `jobs` threads; `done` is called after each with the number so far.
std::vector<Outcome> RunTrials(const std::vector<TrialSpec>& specs, int jobs,
                               const std::function<void(std::size_t done)>& done);

// The table of a kind, as text.
std::string Table(const std::string& kind, const std::vector<Outcome>& outcomes,
                  const CampaignOptions& options);

// Everything of every trial, one JSON object a line.
std::string JsonLines(const std::vector<Outcome>& outcomes);

}  // namespace gyrobench::blind_trials
