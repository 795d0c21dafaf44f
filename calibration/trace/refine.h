// Non-linear parameters of one candidate, refined from their grid point.
#pragma once

#include <Eigen/Core>
#include <functional>
#include <vector>

namespace gyrobench::calibration {

// Minimises |r - X(theta) c|^2 over theta and c, r and X(theta) with the rest of the model taken
// off already. The linear coefficients are eliminated (variable projection), theta by Ceres
// (Levenberg-Marquardt, numeric derivatives) within its bounds. Returns the start where that is
// better than what was found.
std::vector<double> RefineNonlinear(
    const std::function<Eigen::MatrixXd(const std::vector<double>&)>& columns,
    const Eigen::VectorXd& residual, std::vector<double> start, const std::vector<double>& low,
    const std::vector<double>& high);

}  // namespace gyrobench::calibration
