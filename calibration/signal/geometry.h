// The stand's geometry, under the names that this room uses.
#pragma once

#include <array>
#include <cstddef>

#include "kinematics/stand_frame.h"

namespace gyrobench::calibration {

using kinematics::EarthRate;
using kinematics::Matrix3;
using kinematics::QuaternionOrientation;
using kinematics::RotationBetween;
using kinematics::StandFrame;
using kinematics::TransposedTimes;
using kinematics::Vector3;

// The pairs of axes in the order in which non-orthogonality is stated: y and z, z and x, x and y.
// The indices have the type of Eigen's.
inline constexpr std::array<std::array<std::ptrdiff_t, 2>, 3> kAxisPairs = {
    {{1, 2}, {2, 0}, {0, 1}}};

}  // namespace gyrobench::calibration
