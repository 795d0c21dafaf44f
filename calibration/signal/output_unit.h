// The unit of a gyro's output, and what one deg/s is in it by its data sheet.
#pragma once

#include <string>

#include "base/measurement.h"

namespace gyrobench::calibration {

// Unit of the output as results name it: LSB, deg/s.
std::string OutputUnit(const MeasurementInfo& info);
// Nominal output units per deg/s: 1 for a sensor that scales by itself. NaN when not known.
double NominalUnitsPerDegPerS(const MeasurementInfo& info);

}  // namespace gyrobench::calibration
