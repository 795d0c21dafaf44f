// The unit of a gyro's output, and what data sheets say of its scale.
#pragma once

#include <string>

#include "base/measurement.h"

namespace gyrobench::calibration {

// Unit of the output as results name it: LSB, deg/s.
std::string OutputUnit(const MeasurementInfo& info);
// Unit of its columns: LSB, deg/s, rad/s.
std::string ColumnUnit(const MeasurementInfo& info);
// Nominal output units per deg/s: 1 for a sensor that scales by itself. NaN when not known.
double NominalUnitsPerDegPerS(const MeasurementInfo& info);
// Units of the raw output per deg/s, for limits that need no exact figure: counts whose sensitivity
// nobody said are taken for those of the most usual range.
double RoughUnitsPerDeg_s(const MeasurementInfo& info);

// Of the scale factor before anything is measured (MPU-6050 data sheet 3.4, section 6.1): within
// 3 % at 25 degC; another 2 % over temperature.
inline constexpr double kScaleOfDataSheet = 0.03;
// Linear acceleration sensitivity, static.
inline constexpr double kGSensitivityOfDataSheet_deg_s_g = 0.1;
// No MEMS part on the market is off by more than 10 %: twice that is no part but a mistake.
inline constexpr double kLargestScaleError = 0.2;
// How near a factor must be to one that a wrong unit or setting makes: beyond what parts differ by.
inline constexpr double kNearFactor = 0.1;

// Faster than a table or a hand can make it: two samples that differ by more are not of one motion.
inline constexpr double kWildAcceleration_deg_s2 = 5000.0;

}  // namespace gyrobench::calibration
