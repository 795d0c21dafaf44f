// A trace for a person: from the JSON that `gyrobench trace --json` prints and a record keeps.
#pragma once

#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "cli/text_layout.h"

namespace gyrobench::cli {

// A line for each axis with its verdict first; then axis by axis effects, baseline, figures and
// what remains; then the three axes together; then what the data could not show, the inputs and the
// remarks, each said once for all axes. `largest_rates_deg_s`: of the channels in their order, to
// judge nonlinearities by; may be empty. Ends in a newline.
std::string TraceText(const nlohmann::json& trace, const Terminal& terminal,
                      const std::vector<double>& largest_rates_deg_s = {});

// One sentence for each axis: "gyro z: explained by angle.latency, bias.g_linear". Ends in a
// newline; empty when there is no channel.
std::string TraceSummary(const nlohmann::json& trace, const Terminal& terminal);

// "partly explained" of "partly_explained".
std::string VerdictWords(const std::string& verdict);

}  // namespace gyrobench::cli
