// The stand as it is: sensor mounted at an angle, neighbouring axes not square to one another.
#pragma once

#include "kinematics/geometry.h"

namespace gyrobench::kinematics {

// What differs from the perfect stand of docs/measurement-table.md. All zero: that stand.
struct StandGeometry {
  // R_mount = Rz(mount z) Ry(mount y) Rx(mount x) rotates sensor-frame vectors into the inner
  // frame.
  Vector3 mount_deg = {0.0, 0.0, 0.0};
  // The middle axis leans by this from square to the outer one, about the outer frame's y; the
  // inner axis from square to the middle one, about the middle frame's y.
  double outer_middle_deg = 0.0;
  double middle_inner_deg = 0.0;
};

// R_WS = Rz(outer) Ry(outer_middle) Rx(middle) Ry(middle_inner) Rz(inner) R_mount at the angles
// (outer, middle, inner) [deg]: rotates sensor-frame vectors into W.
Matrix3 StandOrientation(const StandGeometry& geometry, const Vector3& angles_deg);

// J with w_WS_S = J d(outer, middle, inner)/dt: column a is the direction of stand axis a in frame
// S.
Matrix3 StandRates(const StandGeometry& geometry, const Vector3& angles_deg);

}  // namespace gyrobench::kinematics
