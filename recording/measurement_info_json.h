// MeasurementInfo as JSON, under the key "measurement" of run.json.
#pragma once

#include <nlohmann/json_fwd.hpp>

#include "base/measurement.h"

namespace gyrobench::recording {

// Every field under its own name; enumerations by name; axes as lists of those present; values that
// are not known are left out.
nlohmann::json ToJson(const MeasurementInfo& info);

// The inverse. A key that is absent keeps its default, a key that is not known here is passed over
// (a later version's). Throws DataError that names the key and what was expected.
MeasurementInfo MeasurementInfoFromJson(const nlohmann::json& json);

}  // namespace gyrobench::recording
