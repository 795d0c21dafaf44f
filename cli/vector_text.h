// The three axes together, for a person: the key `vector` of a trace.
#pragma once

#include <nlohmann/json.hpp>
#include <string>

#include "cli/text_layout.h"

namespace gyrobench::cli {

// Matrix, scale factors, angles, g-sensitivity and accelerometer, each number to the digits that
// its standard error supports; why there is none where there is none. Empty without the key.
std::string VectorText(const nlohmann::json& vector, const Terminal& terminal);

}  // namespace gyrobench::cli
