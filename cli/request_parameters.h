// Parameters of a procedure as the control socket takes them.
#pragma once

#include <nlohmann/json.hpp>
#include <string>

#include "cli/options.h"

namespace gyrobench::cli {

// What reads as a whole as a number or as true or false is one; all else is text.
nlohmann::json ParameterValue(const std::string& text);

// {"procedure", "parameters"}. UsageError when a parameter is given twice.
nlohmann::json RunRequest(const Options& options);

}  // namespace gyrobench::cli
