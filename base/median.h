// The middle one of several values.
#pragma once

#include <vector>

namespace gyrobench {

// Of an even number of values the upper one of the two in the middle; NaN where there are none. The
// values are numbers.
double Median(std::vector<double> values);

}  // namespace gyrobench
