// Numbers as a laboratory writes them: a value to the digits that its standard error supports. They
// are written in characters that every program reads again; Typeset makes a page's of them.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

namespace gyrobench::presentation {

// `value ± std_error`, the standard error to two significant digits and the value to the same
// decimal place: FormatMeasured(0.0076204, 0.0000313) = "0.007620 ± 0.000031". Very large and very
// small values share a power of ten: "(1.2346 ± 0.0012)e-07". A standard error that is missing
// (NaN), zero or infinite leaves the value alone, as FormatNumber writes it; a missing value is
// "-".
std::string FormatMeasured(double value, double std_error);

// `value` to `digits` significant digits, trailing zeros kept off: "0.00762", "1.5e-07". NaN is
// "-".
std::string FormatNumber(double value, int digits = 6);
// To three digits, zeros kept: figures that are compared, "0.620".
std::string FormatFigure(double value);
// At least three significant digits and, below 10, three decimals: figures close to one.
std::string FormatRatio(double value);
// A share, 0..1, as "75.8 %".
std::string FormatPercent(double share);
// "p = 0.0021", "p < 1e-16", "p not known".
std::string FormatPValue(double p);

// `text unit`, without the unit where it is empty or the text is "-".
std::string WithUnit(const std::string& text, const std::string& unit);

// A stretch of time in the two units that matter: "0.25 s", "12.5 s", "3 min 20 s", "1 h 02 min",
// "2 d 03 h". NaN or infinite: "unknown".
std::string FormatDuration(double seconds);
// A count in groups: "1 234 567".
std::string FormatCount(std::int64_t count);
// "2026-11-21 15:30:12 UTC" of microseconds since the epoch; "-" of zero.
std::string FormatUtc(std::int64_t utime);

// A number as it is printed on a page: a true minus, powers of ten as such, spaces at which no line
// breaks; "(−1.23 ± 0.04) × 10⁻⁷" of "(-1.23 ± 0.04)e-07". What is missing, "-", is an en dash.
std::string Typeset(std::string_view number);
// The numbers with a power of ten among words: "p = 1.7 × 10⁻⁴" of "p = 1.7e-04". A part of a word,
// such as "x1e-04" or "1e-04.csv", stays.
std::string TypesetPowers(const std::string& words);
// The unit that a name ends in: "deg/s" of "rate_deg_s", "Hz" of "frequencies_hz"; empty where it
// ends in none.
std::string UnitInName(std::string_view name);
// "deg/s/degC²" of "deg/s/degC^2", "deg/√s" of "deg/sqrt(s)".
std::string TypesetUnit(std::string_view unit);

// Pads with spaces of a digit's and of a point's width, so that right-aligned texts stand with
// their first decimal points in one line.
void AlignDecimals(std::vector<std::string>& texts);

}  // namespace gyrobench::presentation
