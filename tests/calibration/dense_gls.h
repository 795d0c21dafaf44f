// Generalised least squares the plain way: the whole covariance matrix, dense Cholesky. Shares no
// formula with calibration/interval_gls.h, which it checks.
#pragma once

#include <Eigen/Core>
#include <vector>

namespace gyrobench::testing {

// One interval by its times. `begin_angle`, `end_angle`: which reference angles stand at its ends;
// -1 when the table is still.
struct DenseInterval {
  double begin_s = 0.0, end_s = 0.0;
  int begin_angle = -1, end_angle = -1;
};

struct DenseNoise {
  double n = 0.0, k = 0.0, s = 0.0;
};

// Covariance of the outputs:
//   N^2 dt on the diagonal, K^2 int int min(u, v) du dv for the walk that starts from 0 at time 0
//   of bench time, s^2 for each reference angle that two intervals share (with its sign).
Eigen::MatrixXd DenseCovariance(const std::vector<DenseInterval>& intervals,
                                const DenseNoise& noise);

struct DenseSolution {
  Eigen::VectorXd coefficients;
  Eigen::MatrixXd covariance;
  double deviance = 0.0;             // log det V + r' V^-1 r
  double restricted_deviance = 0.0;  // ... + log det X' V^-1 X
};
DenseSolution SolveDense(const Eigen::MatrixXd& v, const Eigen::MatrixXd& x,
                         const Eigen::VectorXd& y);

}  // namespace gyrobench::testing
