// Angles of the stand that fulfil one condition, as far as the axes that can move allow it; whether
// they are near enough and within the limits is for the caller to judge.
#pragma once

#include <array>
#include <vector>

#include "kinematics/find_pose.h"
#include "kinematics/rotations.h"

namespace gyrobench::kinematics {

// Solves for a stand whose axes stand at `rest_deg` where a condition leaves them free.
class PoseCandidates {
 public:
  PoseCandidates(const StandGeometry& geometry, const Vector3& rest_deg,
                 const std::array<bool, 3>& movable)
      : fixed_(geometry), rest_deg_(rest_deg), movable_(movable) {}

  // The outer axis (vertical) lies along the sensor's direction `s`:
  //   Rx(middle) E2 Rz(inner) R_mount s = E1^T z
  // Rx leaves x alone, so that x' of E2 Rz(inner) R_mount s is known: two angles of the inner axis,
  // one of the middle axis to each.
  std::vector<Vector3> OuterAlong(const Eigen::Vector3d& s) const;
  // The middle axis lies along `s`: E2 Rz(inner) R_mount s = x; one angle of the inner axis. Middle
  // and outer axis are free.
  Vector3 MiddleAlong(const Eigen::Vector3d& s) const;
  // Turns the middle axis until `up` is as near to the vertical as it gets, outer and inner as
  // given.
  Vector3 MiddleForUp(Vector3 angles_deg, const Eigen::Vector3d& up) const;
  // R_WS = `orientation` (rotates sensor-frame vectors into W), from z^T R R_mount^T z and what is
  // left of R on either side. With outer and inner axis parallel (gimbal lock) only the sum or
  // difference of their angles is determined: one of them stays.
  std::vector<Vector3> Holding(const Eigen::Matrix3d& orientation) const;

 private:
  std::vector<double> InnerForUp(const Eigen::Vector3d& up_inner) const;
  Vector3 WithOuter(const Eigen::Matrix3d& d, double middle_deg, double outer_deg) const;
  Vector3 WithInner(const Eigen::Matrix3d& d, double middle_deg, double inner_deg) const;

  FixedRotations fixed_;
  Vector3 rest_deg_;
  std::array<bool, 3> movable_;
};

}  // namespace gyrobench::kinematics
