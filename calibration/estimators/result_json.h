// Results as JSON: what result.json, the control socket and `--json` hold.
#pragma once

#include <nlohmann/json_fwd.hpp>

#include "calibration/estimators/results.h"

namespace gyrobench::calibration {

// Keys are the names of the fields of results.h. A number that is not there (NaN) is null. Doubles
// print with as many digits as bring them back to the last bit.
nlohmann::json ToJson(const AnalysisResult& result);

}  // namespace gyrobench::calibration
