// The bias against temperature for a person.
#pragma once

#include <nlohmann/json.hpp>
#include <string>

#include "cli/text_layout.h"

namespace gyrobench::cli {

// One table of all axes, an axis a column; with `pictures` the curves beta(T) below, next to each
// other. `biases`: the list "bias" of a result of `duration_s`.
std::string BiasText(const nlohmann::json& biases, double duration_s, bool pictures,
                     const Terminal& terminal);

// "  - remark" a line each, wrapped to the terminal.
std::string RemarksText(const nlohmann::json& remarks, const Terminal& terminal);

}  // namespace gyrobench::cli
