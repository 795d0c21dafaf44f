#include "calibration/gls/group_offsets.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>
#include <vector>

namespace gyrobench::calibration {
namespace {

constexpr double kAngleWalk = 0.0035, kBiasWalk = 1e-4, kOffset = 0.3;
constexpr int kGroups = 12, kPieces = 25;

// Rests of 25 s in pieces of 1 s with 10 s of turning between them: columns time and output.
struct Rests {
  IntervalSeries series{2};
  std::vector<std::size_t> group;

  Rests(double spread_deg_s, unsigned seed) {
    std::mt19937 random(seed);
    std::normal_distribution<double> normal;
    double walk = 0.0;
    for (int g = 0; g < kGroups; ++g) {
      const double offset = kOffset + spread_deg_s * normal(random);
      for (int i = 0; i < kPieces; ++i) {
        const double gap_s = i == 0 && g > 0 ? 10.0 : 0.0;
        walk += kBiasWalk * std::sqrt(1.0 + gap_s) * normal(random);
        double* row = series.Add({1.0, gap_s, true});
        row[0] = 1.0;
        row[1] = offset + walk + kAngleWalk * normal(random);
        group.push_back(static_cast<std::size_t>(g));
      }
    }
  }
  GroupedOffsets Grouped() const { return {series, group, 0, 1}; }
};

// A random walk alone would have to be so large that nothing is left for the angle random walk.
TEST(GroupOffsets, AreToldFromTheNoiseWithinTheGroups) {
  constexpr int kSeeds = 40;
  constexpr double kSpread = 0.05;
  const double of_mean = kSpread / std::sqrt(kGroups);
  double square = 0.0, claimed = 0.0;
  for (unsigned seed = 1; seed <= kSeeds; ++seed) {
    const Rests rests(kSpread, seed);
    const GroupedOffsets grouped = rests.Grouped();
    const auto noise = grouped.Find({0});
    ASSERT_TRUE(noise) << seed;
    EXPECT_NEAR(noise->noise.angle_random_walk_deg_sqrt_s / kAngleWalk, 1.0, 0.2) << seed;
    EXPECT_LT(noise->noise.bias_random_walk_deg_s_sqrt_s, 1e-3) << seed;
    // Chi-square with 11 degrees of freedom: beyond these in 1 of 10000 seeds.
    EXPECT_GT(noise->spread_deg_s / kSpread, 0.3) << seed;
    EXPECT_LT(noise->spread_deg_s / kSpread, 1.9) << seed;
    const GlsSolution solution = grouped.Solve(*noise, {0});
    ASSERT_TRUE(solution.solvable);
    square += std::pow((solution.coefficients[0] - kOffset) / of_mean, 2) / kSeeds;
    claimed += solution.variance(0) / (of_mean * of_mean) / kSeeds;
  }
  // Chi-square with 39 degrees of freedom.
  EXPECT_GT(square, 0.42);
  EXPECT_LT(square, 1.85);
  EXPECT_NEAR(claimed, 1.0, 0.3);
}

// At one in a thousand hardly ever two of 60, in which the walk is the only thing that differs.
TEST(GroupOffsets, AreNotSeenWhereThereAreNone) {
  int seen = 0;
  for (unsigned seed = 1; seed <= 60; ++seed) seen += Rests(0.0, seed).Grouped().Find({0}) ? 1 : 0;
  EXPECT_LE(seen, 1);
}

// Without a spread worth the name it is generalised least squares as ever.
TEST(GroupOffsets, WithoutSpreadAreOrdinaryLeastSquares) {
  const Rests rests(0.0, 5);
  const GroupNoise noise{{kAngleWalk, kBiasWalk, 0.0}, 1e-9, kGroups};
  const GlsSolution grouped = rests.Grouped().Solve(noise, {0});
  const std::vector<int> regressors = {0};
  const GlsSolution plain = Solve(Whiten(rests.series, noise.noise), regressors, 1);
  EXPECT_NEAR(grouped.coefficients[0], plain.coefficients[0], 1e-9);
  EXPECT_NEAR(grouped.variance(0) / plain.variance(0), 1.0, 1e-6);
}

}  // namespace
}  // namespace gyrobench::calibration
