// What the samples themselves say of how a measurement is described.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "calibration/signal/collector.h"

namespace gyrobench::calibration {

// Sentences without the measurement's name: counts of an unsigned converter whose zero nobody gave,
// an angle of the reference that jumps by whole turns.
std::vector<std::string> IntakeRemarks(const Recording& recording);

// Throws DataError where there is no sample of the gyro, with what was wrong first. `expected`: of
// the measurement.
void RefuseNoSamples(const std::string& source, std::int64_t samples,
                     const std::vector<Defect>& defects, const char* expected);

// Throws DataError where samples come so far apart that no angle can be summed up from them, as
// where t_s is in milliseconds.
void RefuseSamplesFarApart(const Recording& recording);

// What calibrates a sensor without any reference, and what it still takes where that is not there.
std::string WithoutReference(const MeasurementInfo& info);

}  // namespace gyrobench::calibration
