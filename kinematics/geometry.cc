#include "kinematics/geometry.h"

#include <cmath>

#include "base/angle_unit.h"

namespace gyrobench::kinematics {
namespace {

constexpr double kEarthRateDegPerS = 15.041 / 3600.0;

}  // namespace

Vector3 EarthRate(double latitude_deg, double heading_deg) {
  const double latitude = latitude_deg * kRadPerDeg, heading = heading_deg * kRadPerDeg;
  return {kEarthRateDegPerS * std::cos(latitude) * std::cos(heading),
          -kEarthRateDegPerS * std::cos(latitude) * std::sin(heading),
          kEarthRateDegPerS * std::sin(latitude)};
}

Matrix3 QuaternionOrientation(const std::array<double, 4>& q) {
  const double w = q[0], x = q[1], y = q[2], z = q[3];
  return {{{1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)},
           {2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)},
           {2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)}}};
}

Vector3 RotationBetween(const std::array<double, 4>& from, const std::array<double, 4>& to) {
  // conj(from) (x) to, with the sign of the shorter way.
  double w = from[0] * to[0] + from[1] * to[1] + from[2] * to[2] + from[3] * to[3];
  Vector3 v = {from[0] * to[1] - from[1] * to[0] - from[2] * to[3] + from[3] * to[2],
               from[0] * to[2] + from[1] * to[3] - from[2] * to[0] - from[3] * to[1],
               from[0] * to[3] - from[1] * to[2] + from[2] * to[1] - from[3] * to[0]};
  const double sign = w < 0 ? -1.0 : 1.0;
  w *= sign;
  const double sine = std::sqrt(v[0] * v[0] + v[1] * v[1] + v[2] * v[2]);
  const double angle = 2.0 * std::atan2(sine, w);
  // sin(a/2) -> a/2 for small angles: the factor tends to 2.
  const double factor = sign * (sine > 1e-12 ? angle / sine : 2.0) / kRadPerDeg;
  return {v[0] * factor, v[1] * factor, v[2] * factor};
}

Vector3 TransposedTimes(const Matrix3& m, const Vector3& v) {
  Vector3 out = {};
  for (std::size_t column = 0; column < 3; ++column) {
    out[column] = m[0][column] * v[0] + m[1][column] * v[1] + m[2][column] * v[2];
  }
  return out;
}

}  // namespace gyrobench::kinematics
