#include "calibration/sensor/sensor_matrix.h"

#include <Eigen/Dense>
#include <Eigen/LU>
#include <array>
#include <cmath>

#include "base/geometry.h"
#include "kinematics/rotations.h"

namespace gyrobench::calibration {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;
using Matrix39 = Eigen::Matrix<double, 3, 9>;

// Volume that three unit vectors span, below which they do not span space.
constexpr double kLeastVolume = 1e-3;
constexpr double kGimbalLock = 1e-3;  // cosine of the mounting's middle angle

Matrix3d SymmetricRoot(const Matrix3d& g) {
  return Eigen::SelfAdjointEigenSolver<Matrix3d>(g).operatorSqrt();
}

void Put(const Vector3d& from, Vector3& to) { to = {from[0], from[1], from[2]}; }

Vector3 Errors(const Matrix39& slope, const Matrix9& covariance) {
  Vector3 out;
  Put((slope * covariance * slope.transpose()).diagonal().cwiseSqrt(), out);
  return out;
}

// d n_i / d(row i of M) = (I - n_i n_i^T) / scale_i
Matrix39 DirectionSlope(const Vector3d& n, double scale, Eigen::Index i) {
  Matrix39 slope = Matrix39::Zero();
  slope.middleCols<3>(3 * i) = (Matrix3d::Identity() - n * n.transpose()) / scale;
  return slope;
}

// Small turn in N per change of each angle: columns Rz Ry x, Rz y, z.
Matrix3d TurnPerAngle(const Vector3d& angle) {
  const double sb = std::sin(angle[1]), cb = std::cos(angle[1]);
  const double sc = std::sin(angle[2]), cc = std::cos(angle[2]);
  Matrix3d out;
  out << cb * cc, -sc, 0.0, cb * sc, cc, 0.0, -sb, 0.0, 1.0;
  return out;
}

// Of directions N = P Q, Q = R_mount^T: with dQ = [omega]x Q,
//   dN R_mount - (dN R_mount)^T = P [omega]x + [omega]x P = [(tr P - P) omega]x,
// and R_mount turns in N by -R_mount omega.
Matrix39 TurnSlope(const std::array<Matrix39, 3>& directions, const Matrix3d& p,
                   const Matrix3d& r) {
  Matrix39 twice;
  for (Eigen::Index column = 0; column < 9; ++column) {
    Matrix3d dn;
    for (Eigen::Index i = 0; i < 3; ++i)
      dn.row(i) = directions[static_cast<std::size_t>(i)].col(column).transpose();
    const Matrix3d b = dn * r;
    twice.col(column) = Vector3d(b(2, 1) - b(1, 2), b(0, 2) - b(2, 0), b(1, 0) - b(0, 1));
  }
  return -r * (p.trace() * Matrix3d::Identity() - p).inverse() * twice;
}

}  // namespace

std::optional<AxisSplit> SplitAxes(const MatrixWithCovariance& m) {
  const Vector3d scale = m.value.rowwise().norm();
  const Matrix3d n = scale.cwiseInverse().asDiagonal() * m.value;
  if (!(n.determinant() > kLeastVolume)) return std::nullopt;
  const Matrix3d p = SymmetricRoot(n * n.transpose());
  const Matrix3d r = n.transpose() * p.inverse();
  AxisSplit split;
  Put(scale, split.scale);
  std::array<Matrix39, 3> directions;
  Matrix39 scale_slope = Matrix39::Zero(), pair_slope;
  for (Eigen::Index i = 0; i < 3; ++i) {
    directions[static_cast<std::size_t>(i)] = DirectionSlope(n.row(i), scale[i], i);
    scale_slope.block<1, 3>(i, 3 * i) = n.row(i);
  }
  split.scale_std_error = Errors(scale_slope, m.covariance);
  for (std::size_t k = 0; k < 3; ++k) {
    const auto [i, j] = kAxisPairs[k];
    const double sine = n.row(i).dot(n.row(j));
    split.non_orthogonality_deg[k] = std::asin(sine) * kDegPerRad;
    pair_slope.row(static_cast<Eigen::Index>(k)) =
        (n.row(i) * directions[static_cast<std::size_t>(j)] +
         n.row(j) * directions[static_cast<std::size_t>(i)]) *
        (kDegPerRad / std::sqrt(1.0 - sine * sine));
  }
  split.non_orthogonality_std_error_deg = Errors(pair_slope, m.covariance);
  for (std::size_t i = 0; i < 3; ++i)
    Put(r.row(static_cast<Eigen::Index>(i)).transpose(), split.r_mount[i]);
  const Vector3d angle = kinematics::MountAngles_rad(r);
  Put(angle * kDegPerRad, split.mount_deg);
  if (std::fabs(std::cos(angle[1])) < kGimbalLock) return split;
  const Matrix39 turn = kDegPerRad * TurnPerAngle(angle).inverse() * TurnSlope(directions, p, r);
  split.mount_std_error_deg = Errors(turn, m.covariance);
  return split;
}

Matrix3d Recompose(const AxisSplit& split) {
  Matrix3d g = Matrix3d::Identity(), r;
  for (std::size_t k = 0; k < 3; ++k) {
    const auto [i, j] = kAxisPairs[k];
    g(i, j) = g(j, i) = std::sin(split.non_orthogonality_deg[k] / kDegPerRad);
  }
  for (std::size_t i = 0; i < 3; ++i)
    for (std::size_t j = 0; j < 3; ++j)
      r(static_cast<Eigen::Index>(i), static_cast<Eigen::Index>(j)) = split.r_mount[i][j];
  const Vector3d scale(split.scale[0], split.scale[1], split.scale[2]);
  return scale.asDiagonal() * SymmetricRoot(g) * r.transpose();
}

MatrixWithCovariance InverseOver(const MatrixWithCovariance& m, const Eigen::Vector3d& s0) {
  const Eigen::Matrix3d b = m.value.inverse();
  MatrixWithCovariance out;
  out.value = b * s0.cwiseInverse().asDiagonal();
  Matrix9 slope;
  for (Eigen::Index i = 0; i < 3; ++i)
    for (Eigen::Index j = 0; j < 3; ++j)
      for (Eigen::Index k = 0; k < 3; ++k)
        for (Eigen::Index l = 0; l < 3; ++l)
          slope(3 * i + j, 3 * k + l) = -b(i, k) * out.value(l, j);
  out.covariance = slope * m.covariance * slope.transpose();
  return out;
}

}  // namespace gyrobench::calibration
