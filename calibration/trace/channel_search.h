// From a channel's problem to the effects that stand, and the noise under which they do.
#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "calibration/trace/channel_request.h"
#include "calibration/trace/problem.h"
#include "calibration/trace/selection.h"

namespace gyrobench::calibration {

struct SearchedChannel {
  std::shared_ptr<const CandidateSet> candidates;  // that the selection looks at
  Selection selection;
  IntervalNoise noise;
};

// nullopt where the data are too few for it; `remarks` then say so, and what was left out
// otherwise. Problem, baseline and request must outlive the result.
std::optional<SearchedChannel> SearchChannel(const ChannelProblem& problem,
                                             const Baseline& baseline,
                                             std::shared_ptr<const CandidateSet> candidates,
                                             const ChannelRequest& request,
                                             std::vector<std::string>* remarks);

}  // namespace gyrobench::calibration
