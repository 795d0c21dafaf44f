// Results for a person: from the JSON that `gyrobench analyze --json` prints and that a record
// keeps.
#pragma once

#include <nlohmann/json.hpp>
#include <string>

#include "cli/text_layout.h"

namespace gyrobench::cli {

// Tables of scale and bias with units and standard errors, a picture of the bias against
// temperature where it was measured, defects and remarks. Ends in a newline.
std::string ResultText(const nlohmann::json& result, const Terminal& terminal);

// `result` with remarks on the scale factors and biases that effects of the same run's trace touch:
// these numbers are averages over what the effects did in it. As it is where `trace` is null.
nlohmann::json WithTraceRemarks(nlohmann::json result, const nlohmann::json& trace);

// "alpha z 0.0076336 ± 0.0000021 deg/s per LSB" of one result, for a line of a list; empty when
// there is none.
std::string ResultSummary(const nlohmann::json& result);

}  // namespace gyrobench::cli
