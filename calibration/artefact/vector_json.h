// The three axes together as JSON: the key `vector` of trace.json and calibration.json.
#pragma once

#include <nlohmann/json_fwd.hpp>

#include "calibration/sensor/vector_calibration.h"

namespace gyrobench::calibration {

class Place;

// docs/calibration.md. What is not known is null.
nlohmann::json ToJson(const VectorCalibration& vector);

// Reads what ToJson wrote, to the last digit. Throws DataError with file and key where something is
// missing, not known or of another kind.
VectorCalibration VectorFromJson(const Place& place);

}  // namespace gyrobench::calibration
