// Numbers as JSON has them: what is not finite is null. For sources; nlohmann/json is heavy to
// include.
#pragma once

#include <cmath>
#include <cstddef>
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
// A list of rows; `values`: n x n, row-major. Throws std::out_of_range where there are fewer.
template <typename Values>
nlohmann::json SquareRows(const Values& values, std::size_t n) {
  nlohmann::json rows = nlohmann::json::array();
  for (std::size_t i = 0; i < n; ++i) {
    nlohmann::json row = nlohmann::json::array();
    for (std::size_t j = 0; j < n; ++j) row.push_back(Number(values.at(i * n + j)));
    rows.push_back(std::move(row));
  }
  return rows;
}

}  // namespace gyrobench
