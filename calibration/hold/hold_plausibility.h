// Results of held poses that cannot be: what is likelier wrong than the part.
#pragma once

#include <string>
#include <vector>

#include "calibration/hold/hold_model.h"

namespace gyrobench::calibration {

// A sentence for each sensor whose scale is off by more than that of any MEMS part: what was found,
// the likeliest cause, what to check. Empty where all can be. `sensitivity_given`: of the gyro;
// without it there is nothing to compare its scale with.
std::vector<std::string> ImplausibleHold(const HoldState& state, bool sensitivity_given);

}  // namespace gyrobench::calibration
