// Results as a record keeps them: JSON that this program wrote, or an earlier one.
#pragma once

#include <nlohmann/json_fwd.hpp>

#include "calibration/estimators/results.h"
#include "calibration/trace/trace_result.h"

namespace gyrobench::cli {

// A field that is missing, null or of another kind reads as not known, never as an error.
calibration::AnalysisResult ReadAnalysis(const nlohmann::json& json);
calibration::TraceResult ReadTrace(const nlohmann::json& json);

}  // namespace gyrobench::cli
