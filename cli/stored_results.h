// Results as a record keeps them: JSON that this program wrote, or an earlier one.
#pragma once

#include <nlohmann/json_fwd.hpp>

#include "calibration/estimators/results.h"
#include "calibration/trace/trace_result.h"

namespace gyrobench::cli {

// Of result.json. A field that is missing or null reads as not known, never as an error.
calibration::AnalysisResult ReadAnalysis(const nlohmann::json& json);

// Verdict and summary of each channel of trace.json, and the names of its effects: what a summary
// of a trace says. No channels where `json` is null.
calibration::TraceResult ReadVerdicts(const nlohmann::json& json);

}  // namespace gyrobench::cli
