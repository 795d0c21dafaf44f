// A trace for a person: from the JSON that `gyrobench trace --json` prints and a record keeps.
#pragma once

#include <nlohmann/json.hpp>
#include <string>

#include "cli/text_layout.h"

namespace gyrobench::cli {

// Verdict in words first, then effects with their numbers, what cannot be told apart and what would
// settle it, what remains, noise, defects. Ends in a newline.
std::string TraceText(const nlohmann::json& trace, const Terminal& terminal);

// One line for each axis: "gyro z: explained by angle.latency, bias.g_linear". Ends in a newline;
// empty when there is no channel.
std::string TraceSummary(const nlohmann::json& trace, const Terminal& terminal);

// "partly explained" of "partly_explained".
std::string VerdictWords(const std::string& verdict);

}  // namespace gyrobench::cli
