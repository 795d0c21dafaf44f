// How the gyro turned about a node.
#pragma once

#include <cstddef>

namespace gyrobench::calibration {

struct SensorState;

// Angle by which the gyro turned on from the point's time to `tau_s` after it [deg], by a cubic
// through the four known times about that; before the first node and after the last at constant
// rate. NaN where the point is no node.
double TurnedOn(const SensorState& point, std::size_t channel, double tau_s);
// Angular acceleration that the gyro shows so long after the point's time, over 10 ms either way
// [deg/s^2]. NaN where the point is no node.
double AccelerationAfter_deg_s2(const SensorState& point, std::size_t channel, double after_s);

}  // namespace gyrobench::calibration
