// Effects that the measurements at hand cannot show, and what would.
#pragma once

#include <set>
#include <string>
#include <vector>

#include "calibration/trace/problem.h"
#include "calibration/trace/selection.h"
#include "calibration/trace/trace_result.h"

namespace gyrobench::calibration {

// `named`: ids that the trace found. An effect is unidentifiable where the measurements lack what
// it depends on, where the baseline absorbs it, or where its bound (one standard deviation) is
// beyond the largest size that parts of this class show.
std::vector<Unidentifiable> Unidentifiables(const ChannelProblem& problem,
                                            const Selection& selection,
                                            const std::set<std::string>& named,
                                            bool earth_rate_known);

}  // namespace gyrobench::calibration
