// What is asked of one channel; from its problem to the effects that stand, and the noise under
// which they do.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "calibration/state/state_history.h"
#include "calibration/trace/bench_finding.h"
#include "calibration/trace/between_samples.h"
#include "calibration/trace/problem.h"
#include "calibration/trace/selection.h"

namespace gyrobench::calibration {

struct ChannelRequest {
  std::span<const StateHistory> histories;
  std::size_t channel = 2;
  double units_per_deg_s = 1.0;
  std::vector<std::string> covariates;
  bool earth_rate_known = false;
  double false_discovery = 0.001;
  std::uint64_t seed = 1;
  bool curves = true;
  bool try_on_rest = true;
  std::vector<BenchFinding> told;  // by any channel, that this one may feel as well
  // That the channels named when they were traced before; its own among them.
  ReferenceAngleErrors angle_errors;
  std::vector<MisreadAxis> misread;  // MisreadByOthers; taken off
  std::optional<Sampling> sampling;  // as was found then
};

struct SearchedChannel {
  std::shared_ptr<const CandidateSet> candidates;  // that the selection looks at
  Selection selection;
  NoiseModel noise;
};

// nullopt where the data are too few for it; `remarks` then say so, and what was left out
// otherwise. Problem, baseline and request must outlive the result.
std::optional<SearchedChannel> SearchChannel(const ChannelProblem& problem,
                                             const Baseline& baseline,
                                             std::shared_ptr<const CandidateSet> candidates,
                                             const ChannelRequest& request,
                                             std::vector<std::string>* remarks);

}  // namespace gyrobench::calibration
