#include "calibration/sensor/seen_solve.h"

#include <Eigen/Eigenvalues>
#include <cmath>

namespace gyrobench::calibration {

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
