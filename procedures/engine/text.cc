#include "procedures/engine/text.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <cstdint>

#include "base/nearest_word.h"

namespace gyrobench::procedures {
namespace {

// Length of the sequence that `lead` begins, 0 where none may begin so.
std::size_t SequenceLength(std::uint8_t lead) {
  if (lead < 0x80) return lead == 0 ? 0 : 1;
  if (lead < 0xC2) return 0;
  if (lead < 0xE0) return 2;
  if (lead < 0xF0) return 3;
  return lead < 0xF5 ? 4 : 0;
}

// The second byte is bounded where a sequence would be overlong, a surrogate or beyond U+10FFFF.
bool SecondFits(std::uint8_t lead, std::uint8_t second) {
  if (lead == 0xE0) return second >= 0xA0;
  if (lead == 0xED) return second < 0xA0;
  if (lead == 0xF0) return second >= 0x90;
  return lead != 0xF4 || second < 0x90;
}

}  // namespace

std::string DidYouMean(std::string_view word, const std::vector<std::string>& known) {
  // A word that another begins with is half typed, whatever their distance.
  const auto slips = [&](const std::string& other) {
    return word.size() >= 3 && other.starts_with(word) ? 1 : EditDistance(word, other);
  };
  const auto nearest = std::min_element(known.begin(), known.end(),
                                        [&](auto& a, auto& b) { return slips(a) < slips(b); });
  if (nearest == known.end() || slips(*nearest) > static_cast<int>((word.size() + 2) / 3))
    return {};
  return " (did you mean " + *nearest + "?)";
}

bool IsText(std::string_view text) {
  for (std::size_t i = 0; i < text.size();) {
    const auto lead = static_cast<std::uint8_t>(text[i]);
    const std::size_t length = SequenceLength(lead);
    if (length == 0 || i + length > text.size()) return false;
    for (std::size_t k = 1; k < length; ++k) {
      if ((static_cast<std::uint8_t>(text[i + k]) & 0xC0) != 0x80) return false;
    }
    if (length > 1 && !SecondFits(lead, static_cast<std::uint8_t>(text[i + 1]))) return false;
    i += length;
  }
  return true;
}

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
