// How a stand differs from the perfect one of docs/measurement-table.md, "Geometry of the stand".
#pragma once

#include <array>

namespace gyrobench {

// All zero: sensor axes parallel to those of the inner frame, neighbouring stand axes square.
struct StandGeometry {
  // R_mount = Rz(mount z) Ry(mount y) Rx(mount x) rotates sensor-frame vectors into the inner
  // frame.
  std::array<double, 3> mount_deg = {0.0, 0.0, 0.0};
  // The middle axis leans by this from square to the outer one, about the outer frame's y; the
  // inner axis from square to the middle one, about the middle frame's y.
  double outer_middle_deg = 0.0;
  double middle_inner_deg = 0.0;

  bool operator==(const StandGeometry&) const = default;
};

// An angle of the geometry under the name that it has in stand files, records and tables.
struct GeometryAngle {
  const char* name;
  double* value_deg;
  double limit_deg;  // allowed: -limit .. limit
};

inline std::array<GeometryAngle, 5> AnglesOf(StandGeometry& geometry) {
  return {{{"mount_x_deg", &geometry.mount_deg[0], 180.0},
           {"mount_y_deg", &geometry.mount_deg[1], 180.0},
           {"mount_z_deg", &geometry.mount_deg[2], 180.0},
           {"outer_middle_deg", &geometry.outer_middle_deg, 10.0},
           {"middle_inner_deg", &geometry.middle_inner_deg, 10.0}}};
}

}  // namespace gyrobench
