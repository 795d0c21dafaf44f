// Results as a record keeps them: JSON that this program wrote, or an earlier one.
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "calibration/estimators/results.h"
#include "calibration/trace/trace_result.h"
#include "presentation/document.h"

namespace gyrobench::cli {

// A field that is missing, null or of another kind reads as not known, never as an error. A name
// (axis, verdict, whose an effect is ...) that is missing, or that this version does not know, is a
// remark of the result, each of them: which field has which value, and what is known. The entry of
// a list that it belongs to is left out, for any default would be a statement of ours.
calibration::AnalysisResult ReadAnalysis(const nlohmann::json& json);

struct StoredTrace {
  calibration::TraceResult result;
  std::vector<std::string> not_known;  // sentences on what was left out, and why
};
StoredTrace ReadTrace(const nlohmann::json& json);

// Of a run that commissioned the stand (`wiring` of its run.json): what is not as the stand file
// says, which lines of it are wrong, and what is as it should be. Empty where there is none.
presentation::Document WiringDocument(const nlohmann::json& wiring);

}  // namespace gyrobench::cli
