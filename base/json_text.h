// Numbers and text as JSON has them. For sources; nlohmann/json is heavy to include.
#pragma once

#include <cmath>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>

namespace gyrobench {

// What is not finite is null.
inline nlohmann::json Number(double value) {
  return std::isfinite(value) ? nlohmann::json(value) : nlohmann::json(nullptr);
}
inline nlohmann::json Number(const std::optional<double>& value) {
  return value ? Number(*value) : nlohmann::json(nullptr);
}
// A list of them.
template <typename Values>
nlohmann::json Numbers(const Values& values) {
  nlohmann::json list = nlohmann::json::array();
  for (const double value : values) list.push_back(Number(value));
  return list;
}

// JSON as text, whatever bytes it holds: those that are no UTF-8, as a request or a script may
// bring them, become U+FFFD; json::dump alone would throw. `indent`: columns of each level; -1
// makes one line of it all.
std::string JsonText(const nlohmann::json& value, int indent = -1);
std::string JsonText(const nlohmann::ordered_json& value, int indent = -1);

}  // namespace gyrobench
