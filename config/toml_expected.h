// How the checked reader says what it expected. Internal to config/.
#pragma once

#include <fmt/format.h>

#include <string>
#include <string_view>
#include <vector>

#include "config/toml_reader.h"

namespace gyrobench::config {

inline constexpr std::string_view kRequired = "required";
inline constexpr std::string_view kOptional = "optional";
inline constexpr std::string_view kBoolExpected = "true or false";
inline constexpr std::string_view kTextExpected = "a text that is not empty";
inline constexpr std::string_view kPathExpected = "a path";

// "a number in 0.001 .. 1000 deg/s".
template <typename Range>
std::string WithUnit(std::string_view what, const Range& range) {
  std::string text{what};
  const bool has_min = range.min != Range{}.min, has_max = range.max != Range{}.max;
  if (has_min && has_max) text += fmt::format(" in {} .. {}", range.min, range.max);
  if (has_min && !has_max) text += fmt::format(" of at least {}", range.min);
  if (!has_min && has_max) text += fmt::format(" of at most {}", range.max);
  if (!range.unit.empty()) text += fmt::format(" {}", range.unit);
  return text;
}

// "3 numbers", "1 .. 16 paths".
std::string WithLength(std::string_view what, const LengthRange& length);
// `one of "rtu", "tcp"`.
std::string OneOf(const std::vector<std::string_view>& words);

}  // namespace gyrobench::config
