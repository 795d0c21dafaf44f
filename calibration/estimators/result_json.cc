#include "calibration/estimators/result_json.h"

#include "calibration/estimators/result_fields.h"

namespace gyrobench::calibration {

nlohmann::json ToJson(const AnalysisResult& result) { return WriteFields(result); }

}  // namespace gyrobench::calibration
