// The unit of a gyro's output, and what one deg/s is in it by its data sheet.
#pragma once

#include <string>

#include "base/measurement.h"

namespace gyrobench::calibration {

// Unit of the output as results name it: LSB, deg/s.
std::string OutputUnit(const MeasurementInfo& info);
// Nominal output units per deg/s: 1 for a sensor that scales by itself. NaN when not known.
double NominalUnitsPerDegPerS(const MeasurementInfo& info);
// Units of the raw output per deg/s, for limits that need no exact figure: counts whose sensitivity
// nobody said are taken for those of the most usual range.
double RoughUnitsPerDeg_s(const MeasurementInfo& info);

// Faster than a table or a hand can make it: two samples that differ by more are not of one motion.
inline constexpr double kWildAcceleration_deg_s2 = 5000.0;

}  // namespace gyrobench::calibration
