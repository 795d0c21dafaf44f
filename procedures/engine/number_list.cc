#include "procedures/engine/number_list.h"

#include <charconv>
#include <cmath>

namespace gyrobench::procedures {

std::optional<double> ReadNumber(const std::string& text) {
  double value = 0.0;
  const char* end = text.data() + text.size();
  const auto [rest, error] = std::from_chars(text.data(), end, value);
  if (error != std::errc() || rest != end) return std::nullopt;
  return value;
}

std::optional<std::vector<double>> ReadNumbers(const std::string& text) {
  std::vector<double> numbers;
  for (std::size_t begin = 0; begin <= text.size();) {
    const std::size_t comma = std::min(text.find(',', begin), text.size());
    const std::size_t first = text.find_first_not_of(' ', begin);
    if (first == std::string::npos || first >= comma) return std::nullopt;
    const std::size_t last = text.find_last_not_of(' ', comma - 1);
    const auto number = ReadNumber(text.substr(first, last + 1 - first));
    if (!number || !std::isfinite(*number)) return std::nullopt;
    numbers.push_back(*number);
    begin = comma + 1;
  }
  return numbers;
}

}  // namespace gyrobench::procedures
