#include "calibration/effects/catalogue/shared_bases.h"

#include <array>
#include <bit>
#include <cmath>
#include <cstddef>
#include <span>

namespace gyrobench::calibration {
namespace {

// e^(i x). The standard library's complex product asks each result whether it is a number, which
// takes as long as the product.
struct Wave {
  double cosine = 1.0, sine = 0.0;
};
inline Wave operator*(const Wave& a, const Wave& b) {
  return {a.cosine * b.cosine - a.sine * b.sine, a.cosine * b.sine + a.sine * b.cosine};
}

// |x| < 0.5, by its series within 6e-9.
inline Wave TurnedALittle(double x_rad) {
  constexpr double k2 = 1.0 / 2, k3 = k2 / 3, k4 = k3 / 4, k5 = k4 / 5, k6 = k5 / 6, k7 = k6 / 7,
                   k8 = k7 / 8;
  const double y = x_rad * x_rad;
  return {1.0 - y * (k2 - y * (k4 - y * (k6 - y * k8))),
          x_rad * (1.0 - y * (k3 - y * (k5 - y * k7)))};
}

// A power of two: the remainder of a negative number, taken as unsigned, is right as well.
constexpr std::size_t kParts = 64;
static_assert(std::has_single_bit(kParts));
const std::array<Wave, kParts> k64thsOfATurn = [] {
  std::array<Wave, kParts> out;
  for (std::size_t i = 0; i < kParts; ++i) {
    const double x_rad = kTwoPi * static_cast<double>(i) / kParts;
    out[i] = {std::cos(x_rad), std::sin(x_rad)};
  }
  return out;
}();

// e^(i x) within 1e-8, by the nearest 64th of a turn. The C library's sine takes several times as
// long.
inline Wave Turned(double x_rad) {
  constexpr double kLittle_rad = 0.5, kMost_rad = 1e7, kPart_rad = kTwoPi / kParts;
  if (std::fabs(x_rad) < kLittle_rad) return TurnedALittle(x_rad);
  if (!(std::fabs(x_rad) < kMost_rad)) return {std::cos(x_rad), std::sin(x_rad)};
  const auto nearest =
      static_cast<long long>(x_rad * (1.0 / kPart_rad) + std::copysign(0.5, x_rad));
  const auto part = static_cast<std::size_t>(nearest) % kParts;
  return k64thsOfATurn[part] * TurnedALittle(x_rad - static_cast<double>(nearest) * kPart_rad);
}

}  // namespace

// Each wave is the one before, turned on by the mean step and a little: no sine for each of them.
// Errors add up to 3e-7 over 50 readings.
bool WaveOverReadings(const SensorState& point, std::size_t table_axis, double angle_deg,
                      double periods, double* sin_and_cos) {
  const std::span<const double> off_deg = point.readings_off_mean_deg[table_axis];
  if (off_deg.size() < 2) return false;
  const double k = periods * kRadPerDeg;
  const auto count = static_cast<double>(off_deg.size());
  const double step_deg = (off_deg.back() - off_deg.front()) / (count - 1.0);
  const Wave step = Turned(k * step_deg);
  Wave wave = Turned(k * (angle_deg + off_deg.front()));
  double cosines = wave.cosine, sines = wave.sine;
  for (std::size_t i = 1; i < off_deg.size(); ++i) {
    wave = wave * (step * Turned(k * (off_deg[i] - off_deg[i - 1] - step_deg)));
    cosines += wave.cosine;
    sines += wave.sine;
  }
  sin_and_cos[0] = sines / count;
  sin_and_cos[1] = cosines / count;
  return true;
}

}  // namespace gyrobench::calibration
