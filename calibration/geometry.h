// The stand's geometry, under the names that this room uses.
#pragma once

#include "kinematics/geometry.h"

namespace gyrobench::calibration {

using kinematics::EarthRate;
using kinematics::Matrix3;
using kinematics::QuaternionOrientation;
using kinematics::RotationBetween;
using kinematics::StandOrientation;
using kinematics::StandRates;
using kinematics::TransposedTimes;
using kinematics::Vector3;

}  // namespace gyrobench::calibration
