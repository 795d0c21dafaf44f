// Numbers as a laboratory writes them: a value to the digits that its standard error supports.
#pragma once

#include <string>

namespace gyrobench::cli {

// `value ± std_error`, the standard error to two significant digits and the value to the same
// decimal place: FormatMeasured(0.0076204, 0.0000313) = "0.007620 ± 0.000031". Very large and very
// small values share a power of ten: "(1.2346 ± 0.0012)e-07". A standard error that is missing
// (NaN), zero or infinite leaves the value alone, as FormatNumber writes it; a missing value is
// "-".
std::string FormatMeasured(double value, double std_error);

// `value` to `digits` significant digits, trailing zeros kept off: "0.00762", "1.5e-07". NaN is
// "-".
std::string FormatNumber(double value, int digits = 6);

// `text unit`, without the unit where it is empty or the text is "-".
std::string WithUnit(const std::string& text, const std::string& unit);

// A stretch of time in the two units that matter: "0.25 s", "12.5 s", "3 min 20 s", "1 h 02 min",
// "2 d 03 h". NaN or infinite: "unknown".
std::string FormatDuration(double seconds);

// A count with thin groups: "1 234 567".
std::string FormatCount(long long count);

}  // namespace gyrobench::cli
