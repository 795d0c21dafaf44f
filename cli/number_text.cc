#include "cli/number_text.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>

namespace gyrobench::cli {
namespace {

// Values from 1e-4 to below 1e7 are written out; others with a power of ten.
constexpr int kMinPlainExponent = -4;
constexpr int kMaxPlainExponent = 6;
// No double has more.
constexpr int kMaxDigits = 17;

// Decimal exponent of a number once it is rounded to `digits` significant digits: 0.0999 to two is
// 0.10.
int RoundedExponent(double value, int digits) {
  const std::string text = fmt::format("{:.{}e}", value, digits - 1);
  return std::atoi(text.c_str() + text.find('e') + 1);
}

// To the decimal place of 10^place: place -3 is "0.123", place 1 is "120".
std::string ToPlace(double value, int place) {
  if (place <= 0) return fmt::format("{:.{}f}", value, -place);
  const double step = std::pow(10.0, place);
  return fmt::format("{:.0f}", std::round(value / step) * step);
}

}  // namespace

std::string FormatNumber(double value, int digits) {
  if (std::isnan(value)) return "-";
  if (value == 0.0) return "0";
  const int exponent = std::isinf(value) ? 0 : RoundedExponent(value, digits);
  if (exponent > kMaxPlainExponent && exponent < 15 && value == std::floor(value) &&
      digits > exponent) {
    return fmt::format("{:.0f}", value);
  }
  return fmt::format("{:.{}g}", value, digits);
}

std::string FormatMeasured(double value, double std_error) {
  if (!std::isfinite(value) || !std::isfinite(std_error) || std_error <= 0.0) {
    return FormatNumber(value);
  }
  const int error_exponent = RoundedExponent(std_error, 2);
  // The digits of the larger of the two decide how both are written.
  const int exponent =
      std::max(error_exponent, value == 0.0 ? error_exponent : RoundedExponent(value, kMaxDigits));
  int place = std::max(error_exponent - 1, exponent - kMaxDigits + 1);
  if (exponent >= kMinPlainExponent && exponent <= kMaxPlainExponent) {
    return fmt::format("{} ± {}", ToPlace(value, place), ToPlace(std_error, place));
  }
  place -= exponent;
  const double scale = std::pow(10.0, -exponent);
  return fmt::format("({} ± {})e{:+03d}", ToPlace(value * scale, place),
                     ToPlace(std_error * scale, place), exponent);
}

std::string WithUnit(const std::string& text, const std::string& unit) {
  return unit.empty() || text == "-" ? text : text + " " + unit;
}

std::string FormatDuration(double seconds) {
  if (!std::isfinite(seconds)) return "unknown";
  if (seconds < 0.0) return "-" + FormatDuration(-seconds);
  if (seconds < 9.995) return fmt::format("{:.2f} s", seconds);
  if (seconds < 59.95) return fmt::format("{:.1f} s", seconds);
  const auto whole = static_cast<long long>(std::llround(seconds));
  if (whole < 3600) return fmt::format("{} min {:02} s", whole / 60, whole % 60);
  const long long minutes = (whole + 30) / 60;
  if (minutes < 24 * 60) return fmt::format("{} h {:02} min", minutes / 60, minutes % 60);
  const long long hours = (minutes + 30) / 60;
  return fmt::format("{} d {:02} h", hours / 24, hours % 24);
}

std::string FormatCount(long long count) {
  std::string digits = std::to_string(count);
  const std::size_t first = count < 0 ? 1 : 0;
  for (std::size_t i = digits.size(); i > first + 3;) {
    i -= 3;
    digits.insert(i, " ");
  }
  return digits;
}

}  // namespace gyrobench::cli
