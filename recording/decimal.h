// Decimal numbers of a table's fields, fast.
#pragma once

#include <array>
#include <cstdint>

namespace gyrobench::recording {

// 10^0 ... 10^22, all exact in a double.
inline constexpr std::array<double, 23> kPowersOfTen = {
    1e0,  1e1,  1e2,  1e3,  1e4,  1e5,  1e6,  1e7,  1e8,  1e9,  1e10, 1e11,
    1e12, 1e13, 1e14, 1e15, 1e16, 1e17, 1e18, 1e19, 1e20, 1e21, 1e22};

// Reads [-]digits[.digits] at `p` and returns the place after it, or nullptr where the number is
// none of that plain form or has too many digits to be exact this way: std::from_chars is for
// those. Digits as an integer below 2^53 over a power of ten up to 10^22 is one rounding of exact
// operands, so the result is the double nearest to the text (Clinger 1990). The text must be
// followed by a byte that is neither digit nor point.
inline const char* ReadPlainDecimal(const char* p, double& value) {
  constexpr std::uint64_t kExact = std::uint64_t{1} << 53;
  constexpr std::ptrdiff_t kMaxDigits = 18;  // fit 64 bits
  const bool negative = *p == '-';
  p += negative ? 1 : 0;
  std::uint64_t digits = 0;
  const char* begin = p;
  for (; *p >= '0' && *p <= '9'; ++p) digits = digits * 10 + static_cast<std::uint64_t>(*p - '0');
  std::ptrdiff_t count = p - begin;
  std::ptrdiff_t decimals = 0;
  if (*p == '.') {
    begin = ++p;
    for (; *p >= '0' && *p <= '9'; ++p) digits = digits * 10 + static_cast<std::uint64_t>(*p - '0');
    decimals = p - begin;
    count += decimals;
  }
  if (count == 0 || count > kMaxDigits || digits > kExact) return nullptr;
  const double magnitude = static_cast<double>(static_cast<std::int64_t>(digits)) /
                           kPowersOfTen[static_cast<std::size_t>(decimals)];
  value = negative ? -magnitude : magnitude;
  return p;
}

}  // namespace gyrobench::recording
