// Which of a sequence of values leave the others, where those may drift.
#pragma once

#include <cstddef>
#include <vector>

namespace gyrobench {

struct DriftLimits {
  double most = 0.0;   // what a value may differ by from the drift
  double share = 0.0;  // of a value's difference, by which the drift follows it
};

// In the order of time, both ways from the value that is nearest to `usual`: those that leave the
// drift by more than they may, which does not follow them. Empty for no values.
std::vector<bool> AwayFromDrift(const std::vector<double>& values, double usual,
                                const DriftLimits& limits);

}  // namespace gyrobench
