// Where a sensor without a reference was at rest.
#pragma once

#include <vector>

#include "base/measurement.h"
#include "calibration/signal/columns.h"

namespace gyrobench::calibration {

// Without a reference: the whole measurement is one rest, unless the accelerometer shows that the
// sensor was handled; then the stretches of 2 s and more in which neither it nor the gyro changes.
std::vector<Rest> RestsWithoutReference(const MeasurementInfo& info, const Columns& columns);

}  // namespace gyrobench::calibration
