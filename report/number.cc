#include "report/number.h"

#include <fmt/chrono.h>
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <ctime>

namespace gyrobench::report {
namespace {

constexpr std::string_view kNothing = "–";
constexpr std::string_view kMinus = "−";
constexpr std::string_view kThinSpace = "\u202F";
constexpr std::string_view kFigureSpace = "\u2007";
constexpr std::string_view kPointSpace = "\u2008";
constexpr int kDigits = 5;
constexpr int kMaxDecimals = 12;
// Beyond these a number below one is written with a power of ten.
constexpr int kMostDecimals = 6;

// Order of magnitude of `value` once it is rounded to `digits` significant digits.
int Magnitude(double value, int digits) {
  if (value == 0.0 || !std::isfinite(value)) return 0;
  const int rough = static_cast<int>(std::floor(std::log10(std::abs(value))));
  const double rounded = std::round(std::abs(value) / std::pow(10.0, rough - digits + 1));
  return rounded >= std::pow(10.0, digits) ? rough + 1 : rough;
}

// The power of ten, a multiple of three, that leaves 1 to 999 of `size`.
int PowerOfThousand(double size) {
  return 3 * static_cast<int>(std::floor(Magnitude(size, 2) / 3.0));
}

int PowerFor(double size) {
  if (size == 0.0 || !std::isfinite(size) || (size >= 1e-3 && size < 1e5)) return 0;
  return PowerOfThousand(size);
}

std::string GroupThousands(const std::string& digits) {
  std::string grouped;
  for (std::size_t i = 0; i < digits.size(); ++i) {
    if (i > 0 && (digits.size() - i) % 3 == 0 && digits.size() > 4) grouped += kThinSpace;
    grouped += digits[i];
  }
  return grouped;
}

std::string Fixed(double value, int decimals) {
  if (std::isnan(value)) return std::string(kNothing);
  if (std::isinf(value)) return value > 0 ? "∞" : "−∞";
  std::string text = fmt::format("{:.{}f}", std::abs(value), std::clamp(decimals, 0, kMaxDecimals));
  const std::size_t point = text.find('.');
  text = GroupThousands(text.substr(0, point)) +
         (point == std::string::npos ? "" : text.substr(point));
  const bool zero = text.find_first_of("123456789") == std::string::npos;
  return (std::signbit(value) && !zero ? std::string(kMinus) : "") + text;
}

std::string Superscript(int power) {
  static constexpr const char* kDigitsUp[] = {"⁰", "¹", "²", "³", "⁴", "⁵", "⁶", "⁷", "⁸", "⁹"};
  std::string text = power < 0 ? "⁻" : "";
  for (const char digit : std::to_string(std::abs(power))) text += kDigitsUp[digit - '0'];
  return text;
}

std::string TimesPower(const std::string& text, int power) {
  return power == 0 ? text : text + " × 10" + Superscript(power);
}

// Of UTF-8 text.
std::size_t CountCharacters(std::string_view text) {
  return static_cast<std::size_t>(
      std::count_if(text.begin(), text.end(), [](char c) { return (c & 0xC0) != 0x80; }));
}

}  // namespace

Measured RoundTogether(double value, double std_error, double bound) {
  const bool has_error = std::isfinite(std_error) && std_error > 0.0;
  const double size =
      std::max(std::isfinite(value) ? std::abs(value) : 0.0, has_error ? std_error : 0.0);
  const int last_place = has_error ? 1 - Magnitude(std_error, 2) : 0;
  Measured measured;
  measured.power = PowerFor(size);
  if (measured.power == 0 && size < 1.0 && last_place > kMostDecimals) {
    measured.power = PowerOfThousand(size);
  }
  const double scale = std::pow(10.0, -measured.power);
  const int decimals =
      has_error ? last_place + measured.power : kDigits - 1 - Magnitude(value * scale, kDigits);
  measured.value = Fixed(value * scale, decimals);
  measured.error = Fixed(std_error * scale, decimals);
  measured.bound = Fixed(bound * scale, decimals);
  return measured;
}

std::string PrintedUnit(std::string_view unit) {
  std::string printed;
  for (std::size_t i = 0; i < unit.size(); ++i) {
    const bool power =
        unit[i] == '^' && i + 1 < unit.size() && unit[i + 1] >= '0' && unit[i + 1] <= '9';
    if (power) {
      printed += Superscript(unit[++i] - '0');
    } else {
      printed += unit[i];
    }
  }
  return printed;
}

std::string UnitWithPower(int power, std::string_view unit) {
  if (power == 0) return PrintedUnit(unit);
  return fmt::format("10{}{}{}", Superscript(power), unit.empty() ? "" : " ", PrintedUnit(unit));
}

std::string FormatMeasured(double value, double std_error, std::string_view unit) {
  const Measured measured = RoundTogether(value, std_error, std_error);
  const std::string end = unit.empty() ? "" : " " + PrintedUnit(unit);
  if (!std::isfinite(std_error)) return TimesPower(measured.value, measured.power) + end;
  const std::string both = measured.value + " ± " + measured.error;
  return (measured.power == 0 ? both : TimesPower("(" + both + ")", measured.power)) + end;
}

std::string FormatNumber(double value, int digits) {
  if (!std::isfinite(value)) return Fixed(value, 0);
  const int power = PowerFor(std::abs(value)) == 0 ? 0 : Magnitude(value, digits);
  const double scaled = value * std::pow(10.0, -power);
  return TimesPower(Fixed(scaled, digits - 1 - Magnitude(scaled, digits)), power);
}

std::string FormatRatio(double value) {
  return std::abs(value) < 10.0 ? Fixed(value, 3) : FormatNumber(value, 3);
}

std::string FormatPercent(double share) {
  const double percent = 100.0 * share;
  return Fixed(percent, std::abs(percent) < 99.95 ? 1 : 0) + "\u00A0%";
}

std::string FormatPValue(double p) {
  if (!std::isfinite(p)) return "p not estimated";
  if (p < 1e-16) return "p < 10" + Superscript(-16);
  if (p >= 0.001) return "p = " + Fixed(p, 1 - Magnitude(p, 2));
  const int power = Magnitude(p, 1);
  return "p = " + TimesPower(Fixed(p * std::pow(10.0, -power), 0), power);
}

std::string FormatDuration(double seconds) {
  if (!std::isfinite(seconds) || seconds < 0.0) return std::string(kNothing);
  if (seconds < 60.0 || seconds > 1e12) return FormatNumber(seconds, 3) + " s";
  const auto whole = static_cast<std::int64_t>(std::llround(seconds));
  if (whole < 3600) return fmt::format("{} min {:02} s", whole / 60, whole % 60);
  return fmt::format("{} h {:02} min", FormatCount(whole / 3600), whole / 60 % 60);
}

std::string FormatCount(std::int64_t count) {
  const std::string digits = fmt::format("{}", count);
  if (count < 0) return std::string(kMinus) + GroupThousands(digits.substr(1));
  return GroupThousands(digits);
}

std::string FormatUtc(std::int64_t utime) {
  if (utime == 0) return std::string(kNothing);
  const auto seconds = static_cast<std::time_t>(utime / 1'000'000);
  std::tm parts{};
  if (gmtime_r(&seconds, &parts) == nullptr) return std::string(kNothing);
  return fmt::format("{:%Y-%m-%d %H:%M:%S} UTC", parts);
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
    if (have == 0) text += kPointSpace;
    for (std::size_t i = std::max<std::size_t>(have, 1); i < longest; ++i) text += kFigureSpace;
  }
}

}  // namespace gyrobench::report
