// Numbers as they stand in a printed report: rounded by their error, true minus signs, powers of
// ten as such. What is not a number is an en dash.
#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

namespace gyrobench::report {

// A value with its standard error and the bound of that error, all to the decimal place of the
// error's second significant digit, and of the same power of ten (a multiple of three, 0 for
// 0.001 <= size < 100000). Without an error the value has `kDigits` significant digits.
struct Measured {
  std::string value, error, bound;
  int power = 0;
};
Measured RoundTogether(double value, double std_error, double bound);

// "deg/s/degC²" of "deg/s/degC^2".
std::string PrintedUnit(std::string_view unit);
// "10⁻³ deg/s", "deg/s", "10⁶".
std::string UnitWithPower(int power, std::string_view unit);
// "7.620 ± 0.031 ms", "(1.23 ± 0.04) × 10⁻⁶ deg".
std::string FormatMeasured(double value, double std_error, std::string_view unit);

// To `digits` significant digits: "0.620", "1 234", "1.50 × 10⁻⁷".
std::string FormatNumber(double value, int digits = 3);
// At least three significant digits and, below 10, three decimals: figures close to one.
std::string FormatRatio(double value);
// A share, 0..1, as "75.8 %", its space unbreakable.
std::string FormatPercent(double share);
// "p = 0.003", "p = 4 × 10⁻⁹", "p < 10⁻¹⁶".
std::string FormatPValue(double p);
std::string FormatDuration(double seconds);
std::string FormatCount(std::int64_t count);
// "2026-11-21 15:30:12 UTC" of microseconds since the epoch; an en dash of zero.
std::string FormatUtc(std::int64_t utime);

// Pads with spaces of a digit's and of a point's width, so that right-aligned texts stand with
// their decimal points in one line.
void AlignDecimals(std::vector<std::string>& texts);

}  // namespace gyrobench::report
