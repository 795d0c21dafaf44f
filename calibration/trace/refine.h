// Non-linear parameters of one candidate, refined from their grid point.
#pragma once

#include <Eigen/Core>
#include <functional>
#include <optional>
#include <vector>

#include "calibration/trace/candidate.h"
#include "calibration/trace/problem.h"

namespace gyrobench::calibration {

// Where the non-linear parameters of a candidate may go. Of a curve: its middle and its width.
struct RefineRange {
  std::vector<double> start, low, high;
  bool is_coefficient = false;  // the parameter is the coefficient itself
};
// nullopt where there is nothing to refine.
std::optional<RefineRange> RangeOf(const ChannelProblem& problem, const Candidate& candidate);
// How far the number of a ripple's periods in a turn of the table may be from a whole number
// [periods a turn]: by the scale error that a reference may have.
double OffWholePeriods(double periods);
void SetNonlinear(const std::vector<double>& theta, Candidate* candidate);

// Minimises |r - X(theta) c|^2 over theta and c, r and X(theta) with the rest of the model taken
// off already. The linear coefficients are eliminated (variable projection), theta by Ceres
// (Levenberg-Marquardt, numeric derivatives) within its bounds. Returns the start where that is
// better than what was found.
std::vector<double> RefineNonlinear(
    const std::function<Eigen::MatrixXd(const std::vector<double>&)>& columns,
    const Eigen::VectorXd& residual, std::vector<double> start, const std::vector<double>& low,
    const std::vector<double>& high);

}  // namespace gyrobench::calibration
