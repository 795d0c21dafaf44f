// Robust statistics of a sequence: the value in its middle, and those that leave the others where
// all may drift.
#pragma once

#include <cstddef>
#include <vector>

namespace gyrobench {

// Of an even number of values the upper one of the two in the middle; NaN where there are none. The
// values are numbers.
double Median(std::vector<double> values);

// Those of the values, in order, that lie in the range of `width` that holds most of them; of
// equally full ones the lowest. Empty for no values, which are numbers.
std::vector<double> Crowd(std::vector<double> values, double width);

struct DriftLimits {
  double most = 0.0;   // what a value may differ by from the drift
  double share = 0.0;  // of a value's difference, by which the drift follows it
};

// In the order of time, both ways from the value that is nearest to `usual`: those that leave the
// drift by more than they may, which does not follow them. Empty for no values.
std::vector<bool> AwayFromDrift(const std::vector<double>& values, double usual,
                                const DriftLimits& limits);

}  // namespace gyrobench
