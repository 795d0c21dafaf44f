// What a factor between what a sensor puts out and what is true says of the unit that its columns
// are in. One answer for whoever finds the factor: analyze, trace, hold.
#pragma once

#include <optional>
#include <string>

#include "base/measurement.h"

namespace gyrobench::calibration {

// Whether a factor is within kNearFactor of one that a wrong unit or setting makes.
bool IsNearFactor(double value, double factor);

// Of the gyro's columns. `ratio`: true rate over the rate that the columns say, either sign;
// `axis`: x, y or z, or nullopt of all three together. nullopt where no unit makes such a factor.
std::optional<std::string> OtherUnitOfGyro(double ratio, std::optional<char> axis,
                                           const MeasurementInfo& info);
// Of the reference's angles; a quaternion has no unit. `ratio`: as above.
std::optional<std::string> OtherUnitOfReference(double ratio, const MeasurementInfo& info);
// Of the accelerometer's columns, which may be in m/s^2, g or mg where another of these is named.
// `size_g`: of what they say at rest, which should be 1 g.
std::optional<std::string> OtherUnitOfAccelerometer(double size_g);

}  // namespace gyrobench::calibration
