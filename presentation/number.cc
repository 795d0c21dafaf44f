#include "presentation/number.h"

#include <fmt/chrono.h>
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <ctime>
#include <iterator>
#include <regex>
#include <utility>

namespace gyrobench::presentation {
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

std::string Superscript(std::string_view number) {
  static constexpr const char* kDigitsUp[] = {"⁰", "¹", "²", "³", "⁴", "⁵", "⁶", "⁷", "⁸", "⁹"};
  std::string text;
  for (const char c : number) text += c == '-' ? "⁻" : kDigitsUp[c - '0'];
  return text;
}

bool IsDigit(char c) { return c >= '0' && c <= '9'; }

// Of UTF-8 text.
std::size_t CountCharacters(std::string_view text) {
  return static_cast<std::size_t>(std::ranges::count_if(
      text, [](char c) { return (static_cast<unsigned char>(c) & 0xC0U) != 0x80U; }));
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

std::string FormatFigure(double value) {
  if (!std::isfinite(value)) return FormatNumber(value);
  std::string text = fmt::format("{:#.3g}", value);
  if (text.back() == '.') text.pop_back();
  return text;
}

std::string FormatRatio(double value) {
  return std::abs(value) < 10.0 ? fmt::format("{:.3f}", value) : FormatFigure(value);
}

std::string FormatPercent(double share) {
  const double percent = 100.0 * share;
  return fmt::format("{:.{}f} %", percent, std::abs(percent) < 99.95 ? 1 : 0);
}

std::string FormatPValue(double p) {
  if (!std::isfinite(p)) return "p not known";
  return p < 1e-16 ? "p < 1e-16" : fmt::format("p = {:.2g}", p);
}

std::string WithUnit(const std::string& text, const std::string& unit) {
  return unit.empty() || text == "-" ? text : text + " " + unit;
}

std::string FormatDuration(double seconds) {
  if (!std::isfinite(seconds)) return "unknown";
  if (seconds < 0.0) return "-" + FormatDuration(-seconds);
  if (seconds < 9.995) return fmt::format("{:.2f} s", seconds);
  if (seconds < 59.95) return fmt::format("{:.1f} s", seconds);
  if (seconds > 1e12) return FormatNumber(seconds, 3) + " s";
  const auto whole = static_cast<long long>(std::llround(seconds));
  if (whole < 3600) return fmt::format("{} min {:02} s", whole / 60, whole % 60);
  const long long minutes = (whole + 30) / 60;
  if (minutes < 24 * 60) return fmt::format("{} h {:02} min", minutes / 60, minutes % 60);
  const long long hours = (minutes + 30) / 60;
  return fmt::format("{} d {:02} h", hours / 24, hours % 24);
}

std::string FormatCount(std::int64_t count) {
  std::string digits = std::to_string(count);
  const std::size_t first = count < 0 ? 1 : 0;
  for (std::size_t i = digits.size(); i > first + 3;) {
    i -= 3;
    digits.insert(i, " ");
  }
  return digits;
}

std::string FormatUtc(std::int64_t utime) {
  const auto seconds = static_cast<std::time_t>(utime / 1'000'000);
  std::tm parts{};
  if (utime == 0 || gmtime_r(&seconds, &parts) == nullptr) return "-";
  return fmt::format("{:%Y-%m-%d %H:%M:%S} UTC", parts);
}

std::string Typeset(std::string_view number) {
  if (number == "-") return "–";
  std::string text;
  for (std::size_t i = 0; i < number.size(); ++i) {
    const char c = number[i];
    const std::size_t sign = i + 1;
    const bool power = c == 'e' && sign < number.size() &&
                       (number[sign] == '-' || number[sign] == '+') && i > 0 &&
                       (IsDigit(number[i - 1]) || number[i - 1] == ')');
    if (power) {
      const int exponent = std::atoi(std::string(number.substr(sign)).c_str());
      text += "\u00A0×\u00A010" + Superscript(std::to_string(exponent));
      i = std::min(number.find_first_not_of("0123456789", sign + 1), number.size()) - 1;
    } else if (c == '-') {
      text += "−";
    } else if (c == ' ') {
      text += "\u00A0";
    } else {
      text += c;
    }
  }
  return text;
}

std::string TypesetPowers(const std::string& words) {
  static const std::regex kPower(R"((^|[ (<])(-?\d+(\.\d+)?e[+-]\d+)(?=$|[ ,;:)]|\.( |$)))");
  std::string text;
  auto begin = words.begin();
  for (std::sregex_iterator found(words.begin(), words.end(), kPower), end; found != end; ++found) {
    text.append(begin, (*found)[2].first);
    text += Typeset((*found)[2].str());
    begin = (*found)[2].second;
  }
  return text.append(begin, words.end());
}

std::string UnitInName(std::string_view name) {
  static constexpr std::pair<std::string_view, const char*> kUnits[] = {
      {"_deg_s", "deg/s"}, {"_degC", "degC"}, {"_deg", "deg"},  {"_min", "min"},
      {"_s", "s"},         {"_hz", "Hz"},     {"_percent", "%"}};
  const auto found =
      std::ranges::find_if(kUnits, [&](const auto& unit) { return name.ends_with(unit.first); });
  return found == std::end(kUnits) ? "" : found->second;
}

std::string TypesetUnit(std::string_view unit) {
  std::string text;
  for (std::size_t i = 0; i < unit.size(); ++i) {
    if (unit[i] == '^' && i + 1 < unit.size() && IsDigit(unit[i + 1])) {
      text += Superscript(unit.substr(++i, 1));
    } else if (unit.substr(i).starts_with("sqrt(s)")) {
      text += "√s";
      i += 6;
    } else {
      text += unit[i];
    }
  }
  return text;
}

void AlignDecimals(std::vector<std::string>& texts) {
  const auto tail = [](const std::string& text) {
    const std::size_t point = text.find('.');
    return point == std::string::npos ? std::size_t{0} : CountCharacters(text.substr(point));
  };
  std::size_t longest = 0;
  for (const std::string& text : texts) longest = std::max(longest, tail(text));
  for (std::string& text : texts) {
    const std::size_t have = tail(text);
    if (have == longest) continue;
    if (have == 0) text += "\u2008";
    for (std::size_t i = std::max<std::size_t>(have, 1); i < longest; ++i) text += "\u2007";
  }
}

}  // namespace gyrobench::presentation
