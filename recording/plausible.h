// Bounds of what a measurement can hold. Damaged files hold more: numbers whose squares overflow,
// times after which no clock counts.
#pragma once

#include <cmath>
#include <cstdint>

#include "base/clock.h"

namespace gyrobench::recording {

// Squares of such numbers, and sums of them, are still finite.
inline constexpr double kLargestNumber = 1e30;
// 3000 years: seconds and microseconds since any epoch fit, and their differences do not overflow.
inline constexpr double kLatestTime_s = 1e11;
inline constexpr Utime kLatestUtime = 100'000'000'000 * kMicrosecondsPerSecond;

// Sensitivities, ratios, tolerances: what divides and multiplies measured numbers.
inline constexpr double kSmallestFactor = 1e-9;
inline constexpr double kLargestFactor = 1e9;

// A filter that is slower than this is none for a moving sensor.
inline constexpr double kLongestDelay_s = 1.0;
// Count of zero of an unsigned converter of up to 32 bits.
inline constexpr double kLargestZero = 4294967295.0;
// Of a reference angle: relative standard uncertainty, bounds of its errors. Beyond these nothing
// is a reference.
inline constexpr double kLargestScaleUncertainty = 0.1;
inline constexpr double kLargestBound_deg = 10.0;

// A sensor at 1 kHz counts so far in 8000 years.
inline constexpr std::int64_t kMostSamples = std::int64_t{1} << 48;

// False for NaN.
inline bool IsPlausible(double value) { return std::abs(value) <= kLargestNumber; }
inline bool IsFactor(double value) { return value >= kSmallestFactor && value <= kLargestFactor; }
constexpr bool IsPlausible(Utime utime) { return utime >= -kLatestUtime && utime <= kLatestUtime; }

}  // namespace gyrobench::recording
