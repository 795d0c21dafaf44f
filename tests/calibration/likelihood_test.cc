#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>

#include "calibration/gls/statistics.h"

namespace gyrobench::calibration {
namespace {

// The highest of a chain of values, each of which holds a share of the one before: how often it is
// beyond a level, over how often one value is.
double TestsByChance(double correlation, int places, double square, int seeds) {
  std::mt19937 random(1);
  std::normal_distribution<double> normal;
  const double fresh = std::sqrt(1.0 - correlation * correlation);
  int beyond = 0;
  for (int seed = 0; seed < seeds; ++seed) {
    double value = normal(random), highest = value * value;
    for (int i = 1; i < places; ++i) {
      value = correlation * value + fresh * normal(random);
      highest = std::max(highest, value * value);
    }
    beyond += highest > square;
  }
  return beyond / (seeds * std::exp(LogChiSquareTail(square, 1.0)));
}

TEST(Likelihood, TestsOfAScanAreAsManyAsChanceShows) {
  constexpr int kPlaces = 60, kSeeds = 40000;
  constexpr double kSquare = 16.0;
  for (const double apart : {0.02, 0.1, 0.3}) {
    const double expected = 1.0 + kPlaces * TestsFromNeighbour(kSquare, apart);
    // 4 standard deviations of the count, about 70 to 150, and 5 % for the law's own error.
    const double counted = expected * kSeeds * std::exp(LogChiSquareTail(kSquare, 1.0));
    EXPECT_NEAR(TestsByChance(1.0 - apart, kPlaces, kSquare, kSeeds) / expected, 1.0,
                4.0 / std::sqrt(counted) + 0.05)
        << apart;
  }
}

TEST(Likelihood, PlacesThatHaveNothingInCommonAreATestEach) {
  EXPECT_NEAR(TestsFromNeighbour(30.0, 1.0), 1.0, 0.1);
  EXPECT_LE(TestsFromNeighbour(1e6, 1.0), 1.0);
}

TEST(Likelihood, PlacesThatAreNearlyTheSameAreNextToNoTest) {
  EXPECT_EQ(TestsFromNeighbour(30.0, 0.0), 0.0);
  const double near = TestsFromNeighbour(30.0, 1e-6);
  EXPECT_NEAR(TestsFromNeighbour(30.0, 2e-6), 2.0 * near, 0.02 * near);
}

}  // namespace
}  // namespace gyrobench::calibration
