#include "stand/gyro_noise.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace gyrobench::stand {
namespace {

constexpr double kShortest_s = 1.0;
constexpr double kSpacing = 4.0;

}  // namespace

GyroNoise::GyroNoise(const config::GyroScenario& scenario, std::uint64_t seed)
    : scenario_(scenario),
      white_(seed, Source::kGyroWhite),
      walk_(seed, Source::kGyroBiasWalk),
      flicker_(seed, Source::kGyroFlicker),
      tail_(seed, Source::kGyroTail),
      has_flicker_(std::ranges::any_of(scenario.flicker_deg_s, [](double b) { return b != 0.0; })) {
  if (!has_flicker_) return;
  for (Process& process : processes_) {
    for (double& state : process.state) state = flicker_.Normal();
  }
}

void GyroNoise::SetPeriod(double period_s) {
  period_s_ = period_s;
  root_period_ = std::sqrt(period_s);
  root_rate_ = 1.0 / root_period_;
  double tau = kShortest_s;
  for (Process& process : processes_) {
    process.decay = std::exp(-period_s / tau);
    process.kick = std::sqrt(1.0 - process.decay * process.decay);
    tau *= kSpacing;
  }
}

double GyroNoise::Tail() {
  if (scenario_.heavy_tail_fraction == 0.0) return 1.0;
  return tail_.Uniform() < scenario_.heavy_tail_fraction ? scenario_.heavy_tail_factor : 1.0;
}

config::Triple GyroNoise::Next(double period_s) {
  if (period_s != period_s_) SetPeriod(period_s);
  const double white = root_rate_ * Tail();
  config::Triple noise;
  for (std::size_t i = 0; i < 3; ++i) {
    walk_deg_s_[i] += scenario_.bias_random_walk_deg_s_sqrt_s[i] * root_period_ * walk_.Normal();
    noise[i] = walk_deg_s_[i] + scenario_.angle_random_walk_deg_sqrt_s[i] * white * white_.Normal();
  }
  if (!has_flicker_) return noise;
  // Each process has unit variance here; this scale makes the sum's spectrum B^2 / (pi f).
  const double scale = std::sqrt(std::log(kSpacing) / std::numbers::pi);
  for (Process& process : processes_) {
    for (std::size_t i = 0; i < 3; ++i) {
      process.state[i] = process.decay * process.state[i] + process.kick * flicker_.Normal();
      noise[i] += scenario_.flicker_deg_s[i] * scale * process.state[i];
    }
  }
  return noise;
}

}  // namespace gyrobench::stand
