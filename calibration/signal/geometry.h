// The stand's geometry, under the names that this room uses.
#pragma once

#include "kinematics/stand_frame.h"

namespace gyrobench::calibration {

using kinematics::EarthRate;
using kinematics::Matrix3;
using kinematics::QuaternionOrientation;
using kinematics::RotationBetween;
using kinematics::StandFrame;
using kinematics::TransposedTimes;
using kinematics::Vector3;

}  // namespace gyrobench::calibration
