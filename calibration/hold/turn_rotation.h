// The rotation of one turn from the gyro's epochs, and how it moves with the gyro's parameters.
#pragma once

#include <Eigen/Core>
#include <span>

#include "calibration/hold/epoch.h"

namespace gyrobench::calibration {

using Matrix39 = Eigen::Matrix<double, 3, 9>;

// The gyro:  y = M w + beta(t) + G f + noise,  so that  w = A (y - beta - G f),  A = M^-1.
//   y     output over a sensitivity [rad/s], y = unit * xi
//   w     rate of the sensor [rad/s], frame N: the accelerometer's own
//   beta  zero-rate offset [rad/s], straight from `beta_begin` to `beta_end` over the turn
//   G     g-sensitivity [rad/s/g]; f: specific force [g] in N, f = T^-1 (accel - offset)
struct GyroParameters {
  double unit = 1.0;  // rad/s per unit of xi
  Eigen::Matrix3d m = Eigen::Matrix3d::Identity();
  Eigen::Matrix3d g_sensitivity = Eigen::Matrix3d::Zero();
  Eigen::Matrix3d accel_inverse = Eigen::Matrix3d::Identity();  // T^-1
  Eigen::Vector3d accel_offset_g = Eigen::Vector3d::Zero();
};

// R' = R [w]x from R = I: rotates vectors of the frame at the end into that of the beginning. A
// change of the parameters turns it by the small rotation phi in the frame of the beginning,
// dR = [phi]x R; the matrices are phi's derivatives [rad per unit].
struct TurnRotation {
  Eigen::Matrix3d r = Eigen::Matrix3d::Identity();
  Matrix39 by_m = Matrix39::Zero();              // elements row by row: xx xy xz yx ...
  Matrix39 by_g_sensitivity = Matrix39::Zero();  // the same
  Eigen::Matrix3d by_beta_begin = Eigen::Matrix3d::Zero();
  Eigen::Matrix3d by_beta_end = Eigen::Matrix3d::Zero();
  // By a coefficient c_i of further terms c_i n(w_i) in channel i [rad/s]: of |w|, w^2 and w |w|
  // over 1 rad/s, each three columns.
  Matrix39 by_bent_scale = Matrix39::Zero();
};

// Over each epoch the rotation vector is A (angle) + cof(A) (coning), both freed of the offset: the
// matrix is taken through the cross product, (A u) x (A v) = cof(A) (u x v), so that no sample is
// needed again. Terms of third order in the angle of one epoch are left out.
TurnRotation IntegrateTurn(std::span<const Epoch> epochs, const GyroParameters& gyro,
                           const Eigen::Vector3d& beta_begin, const Eigen::Vector3d& beta_end);

// exp([v]x).
Eigen::Matrix3d RotationOf(const Eigen::Vector3d& v);

}  // namespace gyrobench::calibration
