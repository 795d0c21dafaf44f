// How slowly and how fast a stepper drive turns its table, by what its map says of the shaft. What
// the drive itself is told is in turns of the shaft a minute, and in the time in which a ramp
// changes those by 1000.
#pragma once

#include <cmath>

#include "config/stand_config.h"

namespace gyrobench::config {

// Of the table, by one turn of the shaft a minute.
inline double DegSPerRpm(const AxisConfig& axis) {
  constexpr double kOfShaft = 6.0;
  return kOfShaft / std::fabs(axis.gear_ratio);
}
inline double SlowestRate_deg_s(const AxisConfig& axis) {
  return axis.drive.map.min_rpm * DegSPerRpm(axis);
}
inline double FastestRate_deg_s(const AxisConfig& axis) {
  return axis.drive.map.max_rpm * DegSPerRpm(axis);
}
inline double RampPer1000Rpm_ms(const AxisConfig& axis, double acceleration_deg_s2) {
  return 1e6 * DegSPerRpm(axis) / acceleration_deg_s2;
}
inline double SlowestAcceleration_deg_s2(const AxisConfig& axis) {
  return 1e6 * DegSPerRpm(axis) / axis.drive.map.max_ramp_ms_per_1000rpm;
}

}  // namespace gyrobench::config
