#include "calibration/effects/catalogue/shared_bases.h"

#include <cmath>
#include <complex>
#include <span>

namespace gyrobench::calibration {
namespace {

// e^(i x), |x| < 0.5, by its series within 6e-9.
inline std::complex<double> TurnedALittle(double x_rad) {
  constexpr double k2 = 1.0 / 2, k3 = k2 / 3, k4 = k3 / 4, k5 = k4 / 5, k6 = k5 / 6, k7 = k6 / 7,
                   k8 = k7 / 8;
  const double y = x_rad * x_rad;
  return {1.0 - y * (k2 - y * (k4 - y * (k6 - y * k8))),
          x_rad * (1.0 - y * (k3 - y * (k5 - y * k7)))};
}

// e^(i x) within 1e-8, by an eighth of what x is beyond whole turns. The C library's sine takes
// several times as long.
inline std::complex<double> Turned(double x_rad) {
  constexpr double kLittle_rad = 0.5, kMost_rad = 1e7;
  if (std::fabs(x_rad) < kLittle_rad) return TurnedALittle(x_rad);
  if (!(std::fabs(x_rad) < kMost_rad)) return {std::cos(x_rad), std::sin(x_rad)};
  const auto turns = static_cast<long long>(x_rad * (1.0 / kTwoPi) + std::copysign(0.5, x_rad));
  std::complex<double> turned =
      TurnedALittle((x_rad - static_cast<double>(turns) * kTwoPi) * 0.125);
  for (int doubled = 0; doubled < 3; ++doubled) turned *= turned;
  return turned;
}

}  // namespace

// Each wave is the one before, turned on by the mean step and a little: no sine for each of them.
// Errors add up to 3e-7 over 50 readings.
bool WaveOverReadings(const SensorState& point, std::size_t table_axis, double periods,
                      double* sin_and_cos) {
  const std::span<const double> off_deg = point.readings_off_mean_deg[table_axis];
  if (off_deg.size() < 2) return false;
  const double k = periods * kRadPerDeg;
  const auto count = static_cast<double>(off_deg.size());
  const double step_deg = (off_deg.back() - off_deg.front()) / (count - 1.0);
  const std::complex<double> step = Turned(k * step_deg);
  std::complex<double> wave = Turned(k * (point.table_deg[table_axis] + off_deg.front()));
  std::complex<double> sum = wave;
  for (std::size_t i = 1; i < off_deg.size(); ++i) {
    wave *= step * Turned(k * (off_deg[i] - off_deg[i - 1] - step_deg));
    sum += wave;
  }
  sin_and_cos[0] = sum.imag() / count;
  sin_and_cos[1] = sum.real() / count;
  return true;
}

}  // namespace gyrobench::calibration
