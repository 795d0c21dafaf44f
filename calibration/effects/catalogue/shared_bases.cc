#include "calibration/effects/catalogue/shared_bases.h"

#include <cmath>
#include <complex>
#include <span>

namespace gyrobench::calibration {
namespace {

// e^(i x); of a small x by its series, within 6e-9.
std::complex<double> Turned(double x_rad) {
  constexpr double kSmall_rad = 0.5;
  if (!(std::fabs(x_rad) < kSmall_rad)) return std::polar(1.0, x_rad);
  const double y = x_rad * x_rad;
  return {1.0 - y / 2.0 * (1.0 - y / 12.0 * (1.0 - y / 30.0 * (1.0 - y / 56.0))),
          x_rad * (1.0 - y / 6.0 * (1.0 - y / 20.0 * (1.0 - y / 42.0)))};
}

}  // namespace

// Each wave is the one before, turned on by the mean step and a little: no sine for each of them.
bool WaveOverReadings(const SensorState& point, std::size_t table_axis, double periods,
                      double* sin_and_cos) {
  const std::span<const double> off_deg = point.readings_off_mean_deg[table_axis];
  if (off_deg.size() < 2) return false;
  const double k = periods * kRadPerDeg;
  const auto count = static_cast<double>(off_deg.size());
  const double step_deg = (off_deg.back() - off_deg.front()) / (count - 1.0);
  const std::complex<double> step = std::polar(1.0, k * step_deg);
  std::complex<double> wave = std::polar(1.0, k * (point.table_deg[table_axis] + off_deg.front()));
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
