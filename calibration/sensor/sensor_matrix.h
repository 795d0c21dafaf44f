// A sensor's matrix: its inverse with the covariance of its elements, and the matrix as scale
// factors, non-orthogonality and mounting rotation.
#pragma once

#include <Eigen/Core>
#include <optional>

#include "calibration/sensor/vector_calibration.h"

namespace gyrobench::calibration {

using Matrix9 = Eigen::Matrix<double, 9, 9>;
using RowMatrix3 = Eigen::Matrix<double, 3, 3, Eigen::RowMajor>;

// Elements row by row.
struct MatrixWithCovariance {
  Eigen::Matrix3d value = Eigen::Matrix3d::Zero();
  Matrix9 covariance = Matrix9::Zero();
};

// A = M^-1 diag(1 / s0), with B = M^-1:
//   dA_ij = -sum_kl B_ik dM_kl B_lj / s0_j
// The covariance of A by this derivative (delta method): exact to first order of M's errors, which
// are below 1e-4 of it. Not a number where M has no inverse.
MatrixWithCovariance InverseOver(const MatrixWithCovariance& m, const Eigen::Vector3d& s0);

// AxisSplit by the polar decomposition of the sensitive axes' directions, errors by its derivative.
// nullopt where the axes do not span space, or are left-handed: then one axis has its sign
// reversed, and no rotation makes up for it.
std::optional<AxisSplit> SplitAxes(const MatrixWithCovariance& m);

// The matrix that a split is of: diag(scale) sqrt(G) R_mount^T.
Eigen::Matrix3d Recompose(const AxisSplit& split);

}  // namespace gyrobench::calibration
