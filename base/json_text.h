// JSON as text, whatever bytes it holds.
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>

namespace gyrobench {

// Bytes that are no UTF-8, as a request or a script may bring them, become U+FFFD; json::dump alone
// would throw. `indent`: columns of each level; -1 makes one line of it all.
std::string JsonText(const nlohmann::json& value, int indent = -1);
std::string JsonText(const nlohmann::ordered_json& value, int indent = -1);

}  // namespace gyrobench
