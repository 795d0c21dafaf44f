// Least squares of parameters that several fits have in common, and of those of which data show
// only a part.
#pragma once

#include <Eigen/Core>
#include <vector>

namespace gyrobench::calibration {

// Parameters of independent fits, one after the other, and their covariance.
struct JointEstimate {
  Eigen::VectorXd values;
  Eigen::MatrixXd covariance;
  // 2 log L lost by the constraint: chi square of `constraints` degrees where it holds.
  double misfit = 0.0;
  int constraints = 0;
};

// The same under the constraint that the parameters of each group (indices) are equal:
//   p - C H^T (H C H^T)^-1 H p,   C - C H^T (H C H^T)^-1 H C,   H p = 0 the constraint.
// Parameters outside the groups move by their covariance with those inside.
JointEstimate HoldEqual(const JointEstimate& separate,
                        const std::vector<std::vector<Eigen::Index>>& groups);

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
