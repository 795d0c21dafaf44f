#include "calibration/hold/calibrate_hold.h"
#include "calibration/hold/hold_fields.h"

namespace gyrobench::calibration {

nlohmann::json ToJson(const HoldResult& result) { return WriteFields(result); }

}  // namespace gyrobench::calibration
