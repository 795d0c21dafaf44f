// Numbers as JSON has them: what is not finite is null. For sources; nlohmann/json is heavy to
// include.
#pragma once

#include <cmath>
#include <nlohmann/json.hpp>
#include <optional>

namespace gyrobench {

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

}  // namespace gyrobench
