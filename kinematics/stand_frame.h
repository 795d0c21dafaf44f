// Orientation and rates of the sensor from the angles of the stand's axes, for the stand as it is:
// sensor mounted at an angle, neighbouring axes not square to one another.
//
// World W: z up. Sensor S. Right-handed, degrees throughout.
#pragma once

#include <array>

#include "base/geometry.h"

namespace gyrobench::kinematics {

// Earth's rotation in W [deg/s]: 15.041 deg/h (cos lat cos h, -cos lat sin h, sin lat), h the
// heading of W's x axis from north.
Vector3 EarthRate(double latitude_deg, double heading_deg);

// R_WS of a unit quaternion (w, x, y, z).
Matrix3 QuaternionOrientation(const std::array<double, 4>& q_wxyz);

// Rotation vector, in the sensor frame [deg], of the shortest way from one orientation to the next:
//   q_next = q_from (x) exp(v / 2)
Vector3 RotationBetween(const std::array<double, 4>& from_wxyz,
                        const std::array<double, 4>& to_wxyz);

// M^T v: a vector given in W, expressed in S, for M = R_WS.
Vector3 TransposedTimes(const Matrix3& m, const Vector3& v);

// Source: docs/measurement-table.md, "Geometry of the stand". By default the perfect stand.
class StandFrame {
 public:
  StandFrame() : StandFrame(StandGeometry{}) {}
  explicit StandFrame(const StandGeometry& geometry);

  // R_WS = Rz(outer) Ry(outer_middle) Rx(middle) Ry(middle_inner) Rz(inner) R_mount at the angles
  // (outer, middle, inner) [deg]: rotates sensor-frame vectors into W.
  Matrix3 Orientation(const Vector3& angles_deg) const;

  // J with w_WS_S = J d(outer, middle, inner)/dt: column a is the direction of stand axis a in
  // frame S. On the perfect stand [ Rz(inner)^T Rx(middle)^T z,  Rz(inner)^T x,  z ].
  Matrix3 Rates(const Vector3& angles_deg) const;

 private:
  struct Angle {
    double c = 1.0, s = 0.0;
  };
  static Angle At(double angle_deg);
  Matrix3 BetweenOuterAndInner(const Angle& middle) const;

  Angle outer_middle_, middle_inner_;
  bool mounted_ = false;  // R_mount is not I
  Matrix3 mount_ = {};
};

}  // namespace gyrobench::kinematics
