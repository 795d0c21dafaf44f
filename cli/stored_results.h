// Results as a record keeps them: JSON that this program wrote, or an earlier one.
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "calibration/estimators/results.h"
#include "calibration/trace/trace_result.h"

namespace gyrobench::cli {

// A field that is missing, null or of another kind reads as not known, never as an error. An axis
// or a verdict that this version does not know makes the entry that it is of unreadable: the entry
// is left out, and a remark of the result says which field has which value, and what is known.
calibration::AnalysisResult ReadAnalysis(const nlohmann::json& json);

struct StoredTrace {
  calibration::TraceResult result;
  std::vector<std::string> not_known;  // sentences on what was left out, and why
};
StoredTrace ReadTrace(const nlohmann::json& json);

}  // namespace gyrobench::cli
