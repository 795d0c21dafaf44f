// Smoothing of a slow quantity that was measured with noise.
#pragma once

#include <vector>

namespace gyrobench::calibration {

struct Smoothed {
  std::vector<double> value, rate;  // rate per second
};

// A straight line by least squares through what lies within `half_window_s` of each time, or a
// parabola where that fits better, or two lines that meet where those fit clearly better still.
// Values that are NaN do not count; where nothing is near, the result is NaN.
Smoothed SmoothByLines(const std::vector<double>& t_s, const std::vector<double>& value,
                       double half_window_s);

}  // namespace gyrobench::calibration
