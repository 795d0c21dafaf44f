#include "calibration/signal/output_digits.h"

#include <algorithm>
#include <boost/math/tools/roots.hpp>
#include <cmath>
#include <numbers>

namespace gyrobench::calibration {
namespace {

constexpr double kPi = std::numbers::pi;
constexpr std::int64_t kFewPairs = 100;
// Noise in steps: less passes for none, more leaves nothing of the wave.
constexpr double kLeastNoise = 0.02, kMostNoise = 2.0;
// In steps: noise of a step makes such a difference once in two thousand pairs.
constexpr double kFarApart = 5.0;
// In steps: less is lost in the noise that makes it so small.
constexpr double kLeastWave = 0.01;

// That the next sample is the same.
double ChanceOfSame(double noise_in_steps) {
  const double sigma = std::numbers::sqrt2 * noise_in_steps;
  return std::erf(1.0 / (std::numbers::sqrt2 * sigma)) -
         sigma * std::sqrt(2.0 / kPi) * (1.0 - std::exp(-0.5 / (sigma * sigma)));
}

// The same where the level lies on the edge between two steps, which is the least of all levels.
double ChanceOfSameOnAnEdge(double noise_in_steps) {
  constexpr int kSteps = 12;  // on each side; noise of kMostNoise reaches no farther
  double sum = 0.0, below = 0.0;
  for (int k = 1; k <= kSteps; ++k) {
    const double within = 0.5 * std::erf(k / (std::numbers::sqrt2 * noise_in_steps));
    sum += 2.0 * (within - below) * (within - below);
    below = within;
  }
  return sum;
}

double NoiseInSteps(double share_of_same, double (*chance_of_same)(double)) {
  if (share_of_same >= chance_of_same(kLeastNoise)) return 0.0;
  if (share_of_same <= chance_of_same(kMostNoise)) return kMostNoise;
  constexpr int kBits = 20;
  const auto [low, high] = boost::math::tools::bisect(
      [&](double noise) { return chance_of_same(noise) - share_of_same; }, kLeastNoise, kMostNoise,
      boost::math::tools::eps_tolerance<double>(kBits));
  return 0.5 * (low + high);
}

// The least that it may be, wherever the levels are. On an edge half of the samples are the same
// as long as noise is less than 0.4 steps: only what is clearly below half tells of more.
double LeastNoiseInSteps(double share_of_same) {
  constexpr double kClearlyBelowHalf = 0.47;
  const double half = 0.5 * NoiseInSteps(share_of_same, ChanceOfSame);
  if (share_of_same > kClearlyBelowHalf) return half;
  return std::max(half, NoiseInSteps(share_of_same, ChanceOfSameOnAnEdge));
}

}  // namespace

void OutputDigits::Add(double value) {
  const double step = std::fabs(value - last_);
  if (any_) {
    // Far apart are samples of a motion.
    if (least_ == 0.0 || step < kFarApart * least_) ++pairs_;
    if (step == 0.0) ++same_;
    if (step > 0.0 && (least_ == 0.0 || step < least_)) least_ = step;
  }
  last_ = value;
  any_ = true;
}

OutputRounding OutputDigits::Rounding() const {
  if (pairs_ < kFewPairs || same_ == 0 || least_ == 0.0) return {};
  const double share = static_cast<double>(same_) / static_cast<double>(pairs_);
  const double noise = NoiseInSteps(share, ChanceOfSame), surely = LeastNoiseInSteps(share);
  const double wave_in_steps = std::exp(-2.0 * kPi * kPi * surely * surely) / kPi;
  if (wave_in_steps < kLeastWave) return {};
  return {least_, least_ * wave_in_steps, least_ * std::sqrt(noise * noise + 1.0 / 12.0)};
}

}  // namespace gyrobench::calibration
