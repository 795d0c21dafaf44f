#include "calibration/signal/output_digits.h"

#include <boost/math/tools/roots.hpp>
#include <cmath>
#include <numbers>

namespace gyrobench::calibration {
namespace {

constexpr double kPi = std::numbers::pi;
constexpr std::int64_t kFewPairs = 100;
// Noise in steps: less passes for none, more leaves nothing of the wave.
constexpr double kLeastNoise = 0.02, kMostNoise = 2.0;
// In steps: less is lost in the noise that makes it so small.
constexpr double kLeastWave = 0.01;

// That the next sample is the same.
double ChanceOfSame(double noise_in_steps) {
  const double sigma = std::numbers::sqrt2 * noise_in_steps;
  return std::erf(1.0 / (std::numbers::sqrt2 * sigma)) -
         sigma * std::sqrt(2.0 / kPi) * (1.0 - std::exp(-0.5 / (sigma * sigma)));
}

double NoiseInSteps(double share_of_same) {
  if (share_of_same >= ChanceOfSame(kLeastNoise)) return 0.0;
  if (share_of_same <= ChanceOfSame(kMostNoise)) return kMostNoise;
  constexpr int kBits = 20;
  const auto [low, high] = boost::math::tools::bisect(
      [&](double noise) { return ChanceOfSame(noise) - share_of_same; }, kLeastNoise, kMostNoise,
      boost::math::tools::eps_tolerance<double>(kBits));
  return 0.5 * (low + high);
}

}  // namespace

void OutputDigits::Add(double value) {
  const double step = std::fabs(value - last_);
  if (any_) {
    ++pairs_;
    if (step == 0.0) ++same_;
    if (step > 0.0 && (least_ == 0.0 || step < least_)) least_ = step;
  }
  last_ = value;
  any_ = true;
}

OutputRounding OutputDigits::Rounding() const {
  if (pairs_ < kFewPairs || same_ == 0 || least_ == 0.0) return {};
  const double noise = NoiseInSteps(static_cast<double>(same_) / static_cast<double>(pairs_));
  const double surely = 0.5 * noise;
  const double wave_in_steps = std::exp(-2.0 * kPi * kPi * surely * surely) / kPi;
  if (wave_in_steps < kLeastWave) return {};
  return {least_, least_ * wave_in_steps, least_ * std::sqrt(noise * noise + 1.0 / 12.0)};
}

}  // namespace gyrobench::calibration
