// Degrees and radians. Angles and rates are in degrees everywhere; radians are for the functions of
// <cmath> and for formats that want them.
#pragma once

#include <numbers>

namespace gyrobench {

inline constexpr double kRadPerDeg = std::numbers::pi / 180.0;
inline constexpr double kDegPerRad = 180.0 / std::numbers::pi;

}  // namespace gyrobench
