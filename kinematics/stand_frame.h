// Orientation and rates of the sensor from the angles of the stand's axes, for the stand as it is:
// sensor mounted at an angle, neighbouring axes not square to one another.
//
// World W: z up. Sensor S. Right-handed, degrees throughout.
#pragma once

#include "base/stand_geometry.h"
#include "kinematics/geometry.h"

namespace gyrobench::kinematics {

using gyrobench::StandGeometry;

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
