// Rotations of the stand as matrices of Eigen. For sources, not for headers: Eigen is heavy to
// include.
#pragma once

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>

#include "base/geometry.h"
#include "kinematics/stand_frame.h"

namespace gyrobench::kinematics {

inline Eigen::Matrix3d Turned(const Eigen::Vector3d& axis, double angle_deg) {
  return Eigen::AngleAxisd(angle_deg * kRadPerDeg, axis).toRotationMatrix();
}
inline Eigen::Matrix3d AboutX(double deg) { return Turned(Eigen::Vector3d::UnitX(), deg); }
inline Eigen::Matrix3d AboutY(double deg) { return Turned(Eigen::Vector3d::UnitY(), deg); }
inline Eigen::Matrix3d AboutZ(double deg) { return Turned(Eigen::Vector3d::UnitZ(), deg); }

// The constant rotations of a stand.
struct FixedRotations {
  explicit FixedRotations(const StandGeometry& geometry)
      : outer_middle(AboutY(geometry.outer_middle_deg)),
        middle_inner(AboutY(geometry.middle_inner_deg)),
        mount(AboutZ(geometry.mount_deg[2]) * AboutY(geometry.mount_deg[1]) *
              AboutX(geometry.mount_deg[0])) {}
  Eigen::Matrix3d outer_middle, middle_inner, mount;
};

// Angles x, y, z of a rotation Rz(z) Ry(y) Rx(x), as those of a mounting [rad]; y within -pi/2 ..
// pi/2. With y at one of these x and z turn about the same direction, and x is 0.
inline Eigen::Vector3d MountAngles_rad(const Eigen::Matrix3d& rotation) {
  constexpr double kSameDirection = 1e-6;
  const double y = std::asin(std::clamp(-rotation(2, 0), -1.0, 1.0));
  if (std::hypot(rotation(0, 0), rotation(1, 0)) < kSameDirection)
    return {0.0, y, std::atan2(-rotation(0, 1), rotation(1, 1))};
  return {std::atan2(rotation(2, 1), rotation(2, 2)), y,
          std::atan2(rotation(1, 0), rotation(0, 0))};
}

inline Eigen::Vector3d ToEigen(const Vector3& v) { return {v[0], v[1], v[2]}; }

}  // namespace gyrobench::kinematics
