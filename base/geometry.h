// Angles, vectors and the geometry of a stand.
#pragma once

#include <array>
#include <cstddef>
#include <numbers>

namespace gyrobench {

// Degrees and radians. Angles and rates are in degrees everywhere; radians are for the functions of
// <cmath> and for formats that want them.
inline constexpr double kRadPerDeg = std::numbers::pi / 180.0;
inline constexpr double kDegPerRad = 180.0 / std::numbers::pi;
inline constexpr double kFullTurn_deg = 360.0;

using Vector3 = std::array<double, 3>;
using Matrix3 = std::array<Vector3, 3>;  // [row][column]

// The pairs of axes in the order in which non-orthogonality is stated: y and z, z and x, x and y.
// The indices have the type of Eigen's.
inline constexpr std::array<std::array<std::ptrdiff_t, 2>, 3> kAxisPairs = {
    {{1, 2}, {2, 0}, {0, 1}}};

// How a stand differs from the perfect one of docs/measurement-table.md, "Geometry of the stand".
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
