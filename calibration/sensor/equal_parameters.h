// Generalised least squares of parameters that several fits have in common.
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

}  // namespace gyrobench::calibration
