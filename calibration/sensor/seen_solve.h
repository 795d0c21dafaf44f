// Least squares of which data show only a part.
#pragma once

#include <Eigen/Core>
#include <vector>

namespace gyrobench::calibration {

// Mean square of a direction's gravity that counts as shown [g^2]: less is a hundredth of g.
inline constexpr double kLeastGravitySquare_g2 = 1e-4;

struct SeenSolution {
  Eigen::VectorXd values;      // what is not seen: 0
  Eigen::MatrixXd covariance;  // for weights that are inverse variances; of what is seen
  std::vector<bool> seen;      // parameter by parameter
};

// gram^-1 right in the directions whose eigenvalue is more than `least`. A parameter that a
// direction below has a part in is not seen. Parameters have like units, so that eigenvalues mean
// something.
SeenSolution SolveSeen(const Eigen::MatrixXd& gram, const Eigen::VectorXd& right, double least);

}  // namespace gyrobench::calibration
