// A calibration by held poses for a person: from the JSON that `gyrobench hold --json` prints.
#pragma once

#include <nlohmann/json.hpp>
#include <string>

#include "cli/text_layout.h"

namespace gyrobench::cli {

// What was found and used, the verdict, matrices, offset, noise, defects and remarks; or what is
// missing. Ends in a newline.
std::string HoldText(const nlohmann::json& result, const Terminal& terminal);

}  // namespace gyrobench::cli
