// What the samples themselves say of how a measurement is described.
#pragma once

#include <string>
#include <vector>

#include "calibration/signal/collector.h"

namespace gyrobench::calibration {

// Sentences without the measurement's name: counts of an unsigned converter whose zero nobody gave.
std::vector<std::string> IntakeRemarks(const Recording& recording);

// Throws DataError where samples come so far apart that no angle can be summed up from them, as
// where t_s is in milliseconds.
void RefuseSamplesFarApart(const Recording& recording);

// What calibrates a sensor without any reference, and what it still takes where that is not there.
std::string WithoutReference(const MeasurementInfo& info);

}  // namespace gyrobench::calibration
