#include "calibration/vector/equal_parameters.h"

#include <Eigen/Cholesky>

namespace gyrobench::calibration {

JointEstimate HoldEqual(const JointEstimate& separate,
                        const std::vector<std::vector<Eigen::Index>>& groups) {
  Eigen::Index rows = 0;
  for (const auto& group : groups) rows += static_cast<Eigen::Index>(group.size()) - 1;
  if (rows <= 0) return separate;
  Eigen::MatrixXd h = Eigen::MatrixXd::Zero(rows, separate.values.size());
  Eigen::Index row = 0;
  for (const auto& group : groups) {
    for (std::size_t k = 1; k < group.size(); ++k, ++row) {
      h(row, group[0]) = 1.0;
      h(row, group[k]) = -1.0;
    }
  }
  const Eigen::MatrixXd across = separate.covariance * h.transpose();
  Eigen::MatrixXd gram = h * across;
  // Units of the groups differ by orders.
  const Eigen::VectorXd unit = gram.diagonal().cwiseSqrt().cwiseInverse();
  gram = unit.asDiagonal() * gram * unit.asDiagonal();
  const Eigen::LDLT<Eigen::MatrixXd> factor(gram);
  const Eigen::VectorXd difference = unit.asDiagonal() * (h * separate.values);
  const Eigen::MatrixXd gain = across * unit.asDiagonal();
  const Eigen::VectorXd solved = factor.solve(difference);
  JointEstimate out;
  out.values = separate.values - gain * solved;
  out.covariance = separate.covariance - gain * factor.solve(gain.transpose());
  out.misfit = difference.dot(solved);
  out.constraints = static_cast<int>(rows);
  return out;
}

}  // namespace gyrobench::calibration
