// Results that cannot be: what is likelier wrong than the part.
#pragma once

#include <string>
#include <vector>

#include "calibration/results.h"

namespace gyrobench::calibration {

// A sentence or two for each scale factor that is off by more than any MEMS gyro is, as far as a
// nominal sensitivity is known to compare with, and for each axis that turned while its output did
// not follow: what was found, the likeliest cause, what to check. Empty where all can be.
std::vector<std::string> Implausible(const AnalysisResult& result);

}  // namespace gyrobench::calibration
