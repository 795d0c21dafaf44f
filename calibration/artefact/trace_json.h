// A trace as JSON: `gyrobench trace --json` and the record's trace.json.
#pragma once

#include <nlohmann/json_fwd.hpp>

#include "calibration/trace/trace_result.h"

namespace gyrobench::calibration {

inline constexpr const char* kTraceFormat = "gyrobench.trace/1";

// docs/trace.md. What is not a number is null. The curves are left out.
nlohmann::json ToJson(const TraceResult& result);

}  // namespace gyrobench::calibration
