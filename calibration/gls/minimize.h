// Minimum of a smooth function of few variables within bounds, without derivatives.
#pragma once

#include <functional>
#include <vector>

namespace gyrobench::calibration {

struct Minimum {
  std::vector<double> at;
  double value = 0.0;
  int evaluations = 0;
};

// Nelder-Mead from `start` with initial step `step` in each variable; points are clamped to [low,
// high]. Ends when the simplex is below `tolerance` in every variable, or after `max_evaluations`.
// Deterministic. A value that is not a number counts as infinite.
Minimum Minimize(const std::function<double(const std::vector<double>&)>& function,
                 std::vector<double> start, double step, const std::vector<double>& low,
                 const std::vector<double>& high, double tolerance = 1e-3,
                 int max_evaluations = 300);

}  // namespace gyrobench::calibration
