// A calibration by held poses as JSON: docs/hold.md.
#pragma once

#include <nlohmann/json_fwd.hpp>

#include "calibration/hold/hold_result.h"

namespace gyrobench::calibration {

inline constexpr const char* kHoldFormat = "gyrobench.hold/1";

// Keys are the names of the fields of hold_result.h. A number that is not known is null.
nlohmann::json ToJson(const HoldResult& result);

}  // namespace gyrobench::calibration
