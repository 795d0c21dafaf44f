#include "kinematics/stand_frame.h"

#include <cmath>

#include "base/geometry.h"
#include "kinematics/rotations.h"

namespace gyrobench::kinematics {
namespace {

Matrix3 FromEigen(const Eigen::Matrix3d& m) {
  Matrix3 out;
  Eigen::Map<Eigen::Matrix<double, 3, 3, Eigen::RowMajor>>(out[0].data()) = m;
  return out;
}

// Rz(angle)^T v.
Vector3 BackAboutZ(double c, double s, const Vector3& v) {
  return {c * v[0] + s * v[1], c * v[1] - s * v[0], v[2]};
}

}  // namespace

StandFrame::StandFrame(const StandGeometry& geometry)
    : outer_middle_(At(geometry.outer_middle_deg)),
      middle_inner_(At(geometry.middle_inner_deg)),
      mounted_(geometry.mount_deg != Vector3{}),
      mount_(FromEigen(FixedRotations(geometry).mount)) {}

StandFrame::Angle StandFrame::At(double angle_deg) {
  return {std::cos(angle_deg * kRadPerDeg), std::sin(angle_deg * kRadPerDeg)};
}

// Ry(outer_middle) Rx(middle) Ry(middle_inner).
Matrix3 StandFrame::BetweenOuterAndInner(const Angle& m) const {
  const auto [c1, s1] = outer_middle_;
  const auto [c2, s2] = middle_inner_;
  return {{{c1 * c2 - s1 * m.c * s2, s1 * m.s, c1 * s2 + s1 * m.c * c2},
           {m.s * s2, m.c, -m.s * c2},
           {-s1 * c2 - c1 * m.c * s2, c1 * m.s, -s1 * s2 + c1 * m.c * c2}}};
}

Matrix3 StandFrame::Orientation(const Vector3& angles_deg) const {
  const Angle o = At(angles_deg[0]), i = At(angles_deg[2]);
  const Matrix3 between = BetweenOuterAndInner(At(angles_deg[1]));
  Matrix3 rows;  // W's axes in S
  for (std::size_t row = 0; row < 3; ++row) {
    rows[row] = BackAboutZ(i.c, i.s, between[row]);
    if (mounted_) rows[row] = TransposedTimes(mount_, rows[row]);
  }
  const auto [x, y, z] = rows;
  return {{{o.c * x[0] - o.s * y[0], o.c * x[1] - o.s * y[1], o.c * x[2] - o.s * y[2]},
           {o.s * x[0] + o.c * y[0], o.s * x[1] + o.c * y[1], o.s * x[2] + o.c * y[2]},
           z}};
}

Matrix3 StandFrame::Rates(const Vector3& angles_deg) const {
  const Angle i = At(angles_deg[2]);
  const Vector3 up = BetweenOuterAndInner(At(angles_deg[1]))[2];
  Vector3 outer = BackAboutZ(i.c, i.s, up);
  Vector3 middle = BackAboutZ(i.c, i.s, {middle_inner_.c, 0.0, middle_inner_.s});
  Vector3 inner = {0.0, 0.0, 1.0};
  if (mounted_) {
    for (Vector3* axis : {&outer, &middle, &inner}) *axis = TransposedTimes(mount_, *axis);
  }
  return {{{outer[0], middle[0], inner[0]},
           {outer[1], middle[1], inner[1]},
           {outer[2], middle[2], inner[2]}}};
}

namespace {

constexpr double kEarthRateDegPerS = 15.041 / 3600.0;

}  // namespace

Vector3 EarthRate(double latitude_deg, double heading_deg) {
  const double latitude = latitude_deg * kRadPerDeg, heading = heading_deg * kRadPerDeg;
  return {kEarthRateDegPerS * std::cos(latitude) * std::cos(heading),
          -kEarthRateDegPerS * std::cos(latitude) * std::sin(heading),
          kEarthRateDegPerS * std::sin(latitude)};
}

namespace {

Eigen::Quaterniond Quaternion(const std::array<double, 4>& wxyz) {
  return {wxyz[0], wxyz[1], wxyz[2], wxyz[3]};
}

}  // namespace

Matrix3 QuaternionOrientation(const std::array<double, 4>& q) {
  return FromEigen(Quaternion(q).toRotationMatrix());
}

Vector3 RotationBetween(const std::array<double, 4>& from, const std::array<double, 4>& to) {
  // By the shorter way: the angle is at most half a turn.
  const Eigen::AngleAxisd turn(Quaternion(from).conjugate() * Quaternion(to));
  const Eigen::Vector3d v = turn.angle() * kDegPerRad * turn.axis();
  return {v[0], v[1], v[2]};
}

Vector3 TransposedTimes(const Matrix3& m, const Vector3& v) {
  Vector3 out = {};
  for (std::size_t column = 0; column < 3; ++column) {
    out[column] = m[0][column] * v[0] + m[1][column] * v[1] + m[2][column] * v[2];
  }
  return out;
}

}  // namespace gyrobench::kinematics
