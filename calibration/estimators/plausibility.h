// Results that cannot be: what is likelier wrong than the part.
#pragma once

#include <optional>
#include <span>
#include <string>
#include <vector>

#include "base/measurement.h"
#include "calibration/estimators/results.h"

namespace gyrobench::calibration {

// A sentence or two for each scale factor that is off by more than any MEMS gyro is, as far as a
// nominal sensitivity is known to compare with, and for each axis that turned while its output did
// not follow: what was found, the likeliest cause, what to check. Empty where all can be, and where
// the clocks were not started together: no other cause is to be looked for then.
std::vector<std::string> Implausible(const AnalysisResult& result);
// Axes of which it says something.
std::vector<SensorAxis> ImplausibleAxes(const AnalysisResult& result);
// The same of one axis. `ratio`: true rate by the reference over the rate by the gyro's nominal
// sensitivity; NaN where one of them is not known. `inputs`: the measurements that it is of, at
// least one; where they differ in unit, sensitivity or gear, the causes that each allows are named.
// `known_cause`: where something else has shown it. nullopt where it can be.
std::optional<std::string> ImplausibleScale(double ratio, SensorAxis axis,
                                            std::span<const MeasurementInfo* const> inputs,
                                            const std::string& known_cause = {});
// What defects of the data show of the cause; empty where nothing.
std::string CauseAmong(const std::vector<Defect>& defects);

}  // namespace gyrobench::calibration
