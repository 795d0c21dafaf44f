#include "calibration/artefact/trace_json.h"

#include "calibration/artefact/trace_fields.h"

namespace gyrobench::calibration {

nlohmann::json ToJson(const TraceResult& result) { return WriteFields(result); }

}  // namespace gyrobench::calibration
