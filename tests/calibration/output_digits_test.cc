// Rounding of a gyro's output to steps that its noise does not carry it over.
#include "calibration/signal/output_digits.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <numbers>
#include <random>

#include "calibration/gls/whitener.h"
#include "tests/calibration/trace_once.h"
#include "tests/calibration/trace_story.h"

namespace gyrobench::testing {
namespace {

using calibration::ChannelTrace;
using calibration::Interval;
using calibration::OutputDigits;
using calibration::OutputRounding;

constexpr double kStep = 0.0625;

double Rounded(double value) { return kStep * std::round(value / kStep); }

// Of samples at levels that lie anywhere, a hundred at each.
OutputRounding RoundingOf(double noise_in_steps, std::uint64_t seed) {
  std::mt19937_64 random(seed);
  std::normal_distribution<double> normal(0.0, kStep * noise_in_steps);
  std::uniform_real_distribution<double> level(-5.0, 5.0);
  OutputDigits digits;
  for (int k = 0; k < 200; ++k) {
    const double at = level(random);
    for (int i = 0; i < 100; ++i) digits.Add(Rounded(at + normal(random)));
  }
  return digits.Rounding();
}

// How far the mean of rounded samples is from their level, at most over the levels within a step:
// the sum over the steps of their chances.
double WaveOf(double noise_in_steps) {
  const auto below = [&](double edge) {
    return 0.5 * std::erfc(-edge / (std::numbers::sqrt2 * noise_in_steps));
  };
  double largest = 0.0;
  for (double level = 0.0; level < 1.0; level += 1.0 / 64.0) {
    double mean = 0.0;
    for (int k = -20; k <= 20; ++k) mean += k * (below(k + 0.5 - level) - below(k - 0.5 - level));
    largest = std::max(largest, std::fabs(mean - level));
  }
  return kStep * largest;
}

TEST(OutputDigits, TheWaveIsABoundOfWhatRoundingMakesOfAMean) {
  for (const double noise_in_steps : {0.15, 0.25, 0.4, 0.45}) {
    const OutputRounding rounding = RoundingOf(noise_in_steps, 2);
    EXPECT_NEAR(rounding.step, kStep, 1e-12);
    EXPECT_GT(rounding.wave, WaveOf(noise_in_steps)) << noise_in_steps;
    EXPECT_LT(rounding.wave, kStep / std::numbers::pi);
    const double scatter = kStep * std::sqrt(noise_in_steps * noise_in_steps + 1.0 / 12.0);
    EXPECT_NEAR(rounding.scatter, scatter, 0.1 * scatter) << noise_in_steps;
  }
}

// Nothing is stated of noise that leaves less than a hundredth of a step, as that of 0.43 does.
TEST(OutputDigits, NoiseOfMoreThanHalfAStepLeavesNoWave) {
  EXPECT_LT(WaveOf(0.43), 0.01 * kStep);
  for (const double noise_in_steps : {0.6, 0.8, 1.0})
    EXPECT_EQ(RoundingOf(noise_in_steps, 3).wave, 0.0) << noise_in_steps;
}

// A rest on an edge between two steps, beside turns with ramps of eight steps from one sample to
// the next.
TEST(OutputDigits, ARestOnAnEdgeHidesNoWave) {
  for (const double noise_in_steps : {0.3, 0.4}) {
    std::mt19937_64 random(5);
    std::normal_distribution<double> normal(0.0, kStep * noise_in_steps);
    OutputDigits digits;
    for (int i = 0; i < 20000; ++i) {
      const int phase = i % 500;
      const double ramp = phase < 100 ? phase : phase < 200 ? 200 - phase : 0.0;
      digits.Add(Rounded(kStep * (3.5 + 8.0 * ramp) + normal(random)));
    }
    EXPECT_GT(digits.Rounding().wave, WaveOf(noise_in_steps)) << noise_in_steps;
  }
}

TEST(OutputDigits, SamplesThatAreNotRoundedHaveNone) {
  std::mt19937_64 random(4);
  std::normal_distribution<double> normal;
  OutputDigits digits;
  EXPECT_EQ(digits.Rounding().wave, 0.0);
  for (int i = 0; i < 1000; ++i) digits.Add(normal(random));
  EXPECT_EQ(digits.Rounding().wave, 0.0);
}

// After a jump what is known of the bias is as little as where a gap of as much walk lies between.
TEST(AJumpOfTheBias, IsAWalkThroughAGap) {
  constexpr double kGap_s = 7.0;
  const calibration::NoiseModel noise = {0.002, 0.0005, 0.004};
  const double per_n2 =
      std::pow(noise.bias_random_walk_deg_s_sqrt_s / noise.angle_random_walk_deg_sqrt_s, 2);
  std::vector<Interval> gap(30, {.duration_s = 0.1});
  gap.front().new_run = gap.front().new_reference = true;
  std::vector<Interval> jump = gap;
  for (const std::size_t at : {9U, 20U}) {
    gap[at].gap_before_s = kGap_s;
    jump[at].bias_jump_per_s = per_n2 * kGap_s;
  }
  std::mt19937_64 random(5);
  std::normal_distribution<double> normal;
  Eigen::MatrixXd by_gap = Eigen::MatrixXd::NullaryExpr(30, 2, [&] { return normal(random); });
  Eigen::MatrixXd by_jump = by_gap;
  calibration::Whitener(gap, noise).Apply(by_gap);
  calibration::Whitener(jump, noise).Apply(by_jump);
  EXPECT_LT((by_gap - by_jump).cwiseAbs().maxCoeff(), 1e-9 * by_gap.cwiseAbs().maxCoeff());
}

// 16 steps per deg/s and a quarter of a step of noise, at four speeds both ways. Without regard to
// the rounding three of four such tables had a nonlinearity or a resonance named.
TEST(ACoarseGyro, HasNothingNamedThatItsRoundingMakes) {
  Motion motion;
  motion.Rest(15.0);
  for (const double rate : {5.0, 10.0, 20.0, 40.0}) motion.ThereAndBack(kInnerAxis, 360.0, rate);
  for (std::uint64_t seed = 1; seed <= 6; ++seed) {
    Story story;
    story.seed = seed;
    story.Follow(motion);
    story.UseTurningChannelAlone();
    story.white_deg_s = 0.25 * kStep;
    story.info.temperature_present = false;
    story.temperature_degC = [](double) { return 25.0; };
    const double counts = 131.0;  // of the story's unit per deg/s
    const double offset_deg_s = 0.011 * static_cast<double>(seed);
    story.spoil_gyro = [=](GyroSample* sample) {
      for (double& xi : sample->xi) xi = counts * Rounded(xi / counts + offset_deg_s);
      return true;
    };
    const ChannelTrace channel = TraceOf(story.Collect());
    EXPECT_TRUE(channel.effects.empty()) << channel.summary << ", seed " << seed;
  }
}

}  // namespace
}  // namespace gyrobench::testing
