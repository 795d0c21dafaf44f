// How far the gyro turned about a time.
#pragma once

#include "calibration/effects/effect.h"

namespace gyrobench::calibration {

// Angle by which the gyro turned on from the point's time to `tau_s` after it [deg]: the cubic
// through the four known times about it; beyond those that are known at constant rate.
double TurnedOn(const TrackPoint& point, std::size_t channel, double tau_s);

}  // namespace gyrobench::calibration
