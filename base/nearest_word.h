// What was meant by a word or a number that is not understood: for hints in messages.
#pragma once

#include <charconv>
#include <optional>
#include <string>
#include <string_view>
#include <system_error>
#include <vector>

namespace gyrobench {

// Insertions, deletions and replacements of one letter, and swaps of two neighbours, that turn `a`
// into `b`.
int EditDistance(std::string_view a, std::string_view b);

// `did you mean "gear_ratio"?` with the nearest of `known` (the first of equals). Where that is not
// near also the whole list: `did you mean "site"? (known here: "gyro", "site")`; where it is far,
// the list alone: `known here: "bus", "unit"`.
std::string Suggestion(std::string_view word, const std::vector<std::string>& known);

// "0,5" as "0.5"; nothing where `text` is not one number with one comma between digits.
inline std::optional<std::string> WithDecimalPoint(std::string_view text) {
  const auto is_digit = [&](std::size_t i) {
    return i < text.size() && text[i] >= '0' && text[i] <= '9';
  };
  const std::size_t comma = text.find(',');
  if (comma == std::string_view::npos || comma == 0) return std::nullopt;
  if (!is_digit(comma - 1) || !is_digit(comma + 1)) return std::nullopt;
  std::string point(text);
  point[comma] = '.';
  double number = 0.0;
  const auto [end, error] = std::from_chars(point.data(), point.data() + point.size(), number);
  if (error != std::errc() || end != point.data() + point.size()) return std::nullopt;
  return point;
}

}  // namespace gyrobench
