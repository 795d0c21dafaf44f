// What the channels of a trace have in common, said once.
#pragma once

#include <nlohmann/json.hpp>
#include <string>

#include "cli/text_layout.h"

namespace gyrobench::cli {

// Effects that were not to be seen, by reason: the reason, the ids, and once each manoeuvre that
// would show them. Channels with the same ids for a reason share its lines. Figures are left to
// --json. Empty where there is none.
std::string UnseenText(const nlohmann::json& channels, const Terminal& terminal);

// Remarks of the channels, each once with the axes that it is for, and those of the whole.
std::string TraceRemarks(const nlohmann::json& trace, const Terminal& terminal);

}  // namespace gyrobench::cli
