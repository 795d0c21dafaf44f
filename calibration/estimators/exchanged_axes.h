// Columns or axes of the gyro that stand for each other.
#pragma once

#include <string>

#include "base/measurement.h"
#include "calibration/signal/columns.h"

namespace gyrobench::calibration {

// A sentence that names another channel of the gyro which follows what the reference turns about
// `axis` (of the sensor's frame), while that of `axis` itself does not: columns exchanged, or a
// mounting that is not declared. Compared are the channels alone, so that no sensitivity needs to
// be known. Empty where none does.
std::string FollowedByAnother(const Columns& columns, SensorAxis axis);

}  // namespace gyrobench::calibration
