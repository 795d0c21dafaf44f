// The noise's statistics against their textbook formulas.
#include "stand/gyro_noise.h"

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

namespace gyrobench::stand {
namespace {

config::GyroScenario Silent() { return config::IdealScenario().gyro; }

std::vector<double> Draw(const config::GyroScenario& scenario, std::uint64_t seed,
                         std::size_t count, double period_s) {
  GyroNoise noise(scenario, seed);
  std::vector<double> values(count);
  for (double& value : values) value = noise.Next(period_s)[2];
  return values;
}

// Allan variance of means over `m` samples, not overlapping.
double AllanVariance(const std::vector<double>& values, std::size_t m) {
  std::vector<double> means;
  for (std::size_t i = 0; i + m <= values.size(); i += m) {
    double sum = 0.0;
    for (std::size_t k = 0; k < m; ++k) sum += values[i + k];
    means.push_back(sum / static_cast<double>(m));
  }
  double sum = 0.0;
  for (std::size_t i = 1; i < means.size(); ++i) sum += std::pow(means[i] - means[i - 1], 2);
  return sum / (2.0 * static_cast<double>(means.size() - 1));
}

TEST(GyroNoise, WhiteNoiseHasTheAllanDeviationOfItsAngleRandomWalkAtAnySampleRate) {
  auto scenario = Silent();
  const double N = 0.0035;
  scenario.angle_random_walk_deg_sqrt_s = {N, N, N};
  for (const double period_s : {0.001, 0.005, 0.02}) {
    double sum = 0.0;
    const int kSeeds = 20;
    for (std::uint64_t seed = 1; seed <= kSeeds; ++seed) {
      sum += AllanVariance(Draw(scenario, seed, 40000, period_s), 20);
    }
    // sigma^2(tau) = N^2 / tau; 2000 clusters x 20 seeds leave 0.9 % of scatter.
    EXPECT_NEAR(sum / kSeeds / (N * N / (20 * period_s)), 1.0, 0.04) << period_s;
  }
}

TEST(GyroNoise, TheBiasWalksWithTheAllanDeviationOfItsRandomWalk) {
  auto scenario = Silent();
  const double K = 1e-4;
  scenario.bias_random_walk_deg_s_sqrt_s = {K, K, K};
  double sum = 0.0;
  const int kSeeds = 60;
  for (std::uint64_t seed = 1; seed <= kSeeds; ++seed) {
    sum += AllanVariance(Draw(scenario, seed, 40000, 0.01), 400);
  }
  // sigma^2(tau) = K^2 tau / 3; 6000 clusters, correlated.
  EXPECT_NEAR(sum / kSeeds / (K * K * 4.0 / 3.0), 1.0, 0.08);
}

TEST(GyroNoise, FlickerHasAFlatAllanDeviationOfTwoThirdsOfItsInstability) {
  auto scenario = Silent();
  const double B = 0.01;
  scenario.flicker_deg_s = {B, B, B};
  for (const std::size_t m : {100U, 400U, 1600U}) {
    double sum = 0.0;
    const int kSeeds = 40;
    for (std::uint64_t seed = 1; seed <= kSeeds; ++seed) {
      sum += AllanVariance(Draw(scenario, seed, 32000, 0.1), m);
    }
    // sigma^2 = 2 ln 2 / pi B^2; the sum of exponentials follows 1/f within some per cent.
    EXPECT_NEAR(sum / kSeeds / (2 * std::log(2.0) / 3.14159 * B * B), 1.0, 0.2) << m;
  }
}

TEST(GyroNoise, AFractionOfTheSamplesHasHeavyTails) {
  auto scenario = Silent();
  scenario.angle_random_walk_deg_sqrt_s = {1, 1, 1};
  scenario.heavy_tail_fraction = 0.05;
  scenario.heavy_tail_factor = 10;
  const std::vector<double> values = Draw(scenario, 3, 200000, 1.0);
  double variance = 0.0;
  double far = 0.0;
  for (const double value : values) {
    variance += value * value / 200000;
    far += std::abs(value) > 5 ? 1.0 / 200000 : 0.0;
  }
  EXPECT_NEAR(variance, 0.95 + 0.05 * 100, 0.3);
  EXPECT_NEAR(far, 0.05 * std::erfc(0.5 / std::sqrt(2.0)), 0.003);
}

TEST(GyroNoise, OneSourceDrawsTheSameWhateverTheOthersDo) {
  auto quiet = Silent();
  quiet.bias_random_walk_deg_s_sqrt_s = {1e-4, 1e-4, 1e-4};
  auto loud = quiet;
  loud.flicker_deg_s = {0.1, 0.1, 0.1};
  loud.heavy_tail_fraction = 0.5;
  GyroNoise a(quiet, 9);
  GyroNoise b(loud, 9);
  for (int i = 0; i < 1000; ++i) {
    a.Next(0.005);
    b.Next(0.005);
    ASSERT_EQ(a.walk_deg_s(), b.walk_deg_s());
  }
}

TEST(GyroNoise, DifferentSeedsAndAxesAreUncorrelated) {
  auto scenario = Silent();
  scenario.angle_random_walk_deg_sqrt_s = {1, 1, 1};
  GyroNoise a(scenario, 1);
  GyroNoise b(scenario, 2);
  double seeds = 0.0;
  double axes = 0.0;
  const int kCount = 100000;
  for (int i = 0; i < kCount; ++i) {
    const auto x = a.Next(1.0);
    const auto y = b.Next(1.0);
    seeds += x[0] * y[0] / kCount;
    axes += x[0] * x[1] / kCount;
  }
  EXPECT_NEAR(seeds, 0.0, 5 / std::sqrt(kCount));
  EXPECT_NEAR(axes, 0.0, 5 / std::sqrt(kCount));
}

}  // namespace
}  // namespace gyrobench::stand
