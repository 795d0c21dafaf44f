#include "calibration/sensor/least_squares.h"

#include <Eigen/Eigenvalues>
#include <cmath>

#include "calibration/gls/scaled_ldlt.h"

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
  const ScaledLdlt factor(h * across);
  const Eigen::VectorXd difference = h * separate.values;
  const Eigen::VectorXd solved = factor.Solve(difference);
  JointEstimate out;
  out.values = separate.values - across * solved;
  out.covariance = separate.covariance - across * factor.Solve(across.transpose());
  out.misfit = difference.dot(solved);
  out.constraints = static_cast<int>(rows);
  return out;
}

SeenSolution SolveSeen(const Eigen::MatrixXd& gram, const Eigen::VectorXd& right, double least) {
  constexpr double kHasPart = 1e-3;
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> eigen(gram);
  const Eigen::MatrixXd& directions = eigen.eigenvectors();
  Eigen::VectorXd inverse = Eigen::VectorXd::Zero(gram.rows());
  SeenSolution out;
  out.seen.assign(static_cast<std::size_t>(gram.rows()), true);
  for (Eigen::Index k = 0; k < gram.rows(); ++k) {
    if (eigen.eigenvalues()[k] > least) {
      inverse[k] = 1.0 / eigen.eigenvalues()[k];
      continue;
    }
    for (Eigen::Index j = 0; j < gram.rows(); ++j)
      if (std::fabs(directions(j, k)) > kHasPart) out.seen[static_cast<std::size_t>(j)] = false;
  }
  out.covariance = directions * inverse.asDiagonal() * directions.transpose();
  out.values = out.covariance * right;
  return out;
}

}  // namespace gyrobench::calibration
