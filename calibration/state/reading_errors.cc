// What the mean of several readings of the reference is worth.
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <numbers>
#include <vector>

#include "calibration/state/history_parts.h"

namespace gyrobench::calibration {
namespace {

// Noise of half a step spreads the readings so evenly that rounding is noise as well (Widrow and
// Kollar, Quantization Noise, 2008).
constexpr double kDither = 0.5;

// Half of the readings are in rests that scatter no more than that: the turns that pass for rests
// are many and short.
double MedianScatter(std::vector<Rest> rests) {
  std::ranges::sort(rests, {}, &Rest::scatter_deg);
  std::int64_t left = 0;
  for (const Rest& rest : rests) left += rest.readings;
  left /= 2;
  for (const Rest& rest : rests) {
    left -= rest.readings;
    if (left <= 0) return rest.scatter_deg;
  }
  return rests.back().scatter_deg;
}

}  // namespace

ReadingErrors::ReadingErrors(const Recording& recording) : step_deg_(recording.reference_step_deg) {
  for (const double step : step_deg_) {
    if (std::isfinite(step)) largest_step_deg_ = std::max(largest_step_deg_, step);
  }
  const std::vector<Rest>& rests = recording.columns.rests;
  if (rests.empty()) return;
  scatter_deg_ = MedianScatter(rests);
  if (!(largest_step_deg_ > 0.0)) return;
  const double dither = scatter_deg_ / (kDither * largest_step_deg_);
  rounded_ = std::clamp(1.0 - dither * dither, 0.0, 1.0);
}

double ReadingErrors::ErrorInMotion_deg(double readings) const {
  return std::max(scatter_deg_ / std::sqrt(readings), rounded_ * 0.5 * largest_step_deg_);
}

double ReadingErrors::ShareAtRest(double readings) const {
  return rounded_ + (1.0 - rounded_) / readings;
}

double ReadingErrors::ShareInMotion(const ReadingsMean& mean, std::size_t axis,
                                    const Vector3& from_deg, const Vector3& to_deg) const {
  const Vector3& own = mean.own_readings;
  // Of an orientation there are no readings of one axis.
  const bool of_axes = own[0] + own[1] + own[2] > 0.0;
  const double readings = of_axes ? std::max(own[axis], 1.0) : mean.readings;
  double steps = 0.0;
  for (std::size_t a = 0; a < 3; ++a) {
    const double passed = std::fabs(to_deg[a] - from_deg[a]) / step_deg_[a];
    if (std::isfinite(passed)) steps = std::max(steps, passed);
  }
  return rounded_ / std::min(readings, 1.0 + steps) + (1.0 - rounded_) / readings;
}

// The first harmonic of the rounding's error (Widrow and Kollar, Quantization Noise, 2008, 4.2):
// q / pi exp(-2 pi^2 sigma^2 / q^2). Rounding scatters by q^2 / 12 more at most.
double WaveOfRounding_deg(double step_deg, double scatter_deg) {
  if (!(step_deg > 0.0)) return 0.0;
  const double scatter_in_steps = std::fmax(0.0, scatter_deg) / step_deg;
  const double noise_square = std::max(0.0, scatter_in_steps * scatter_in_steps - 1.0 / 12.0);
  return step_deg / std::numbers::pi *
         std::exp(-2.0 * std::numbers::pi * std::numbers::pi * noise_square);
}

}  // namespace gyrobench::calibration
