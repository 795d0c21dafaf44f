#include "calibration/trace/likelihood.h"

#include <gtest/gtest.h>

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <random>

namespace gyrobench::calibration {
namespace {

// Means before and after each place of white noise, compared: a step is looked for everywhere.
TEST(Likelihood, TestsOfAScanForAStepAreAsManyAsChanceShows) {
  constexpr int kRows = 400, kEdge = 20, kSeeds = 6000;
  constexpr double kSquare = 12.0;
  double tests = 0.0;
  auto correlation = [](double i, double j) {
    return std::sqrt(i * (kRows - j) / (j * (kRows - i)));
  };
  for (int i = kEdge; i < kRows - kEdge; ++i)
    tests += TestsFromNeighbour(kSquare, 1.0 - correlation(i, i + 1));
  int beyond = 0;
  std::mt19937 random(1);
  std::normal_distribution<double> normal;
  Eigen::VectorXd sums = Eigen::VectorXd::Zero(kRows + 1);
  for (int seed = 0; seed < kSeeds; ++seed) {
    for (int i = 0; i < kRows; ++i) sums[i + 1] = sums[i] + normal(random);
    double highest = 0.0;
    for (int i = kEdge; i <= kRows - kEdge; ++i) {
      const double apart = sums[i] - sums[kRows] * i / kRows;
      highest = std::max(highest, apart * apart * kRows / (i * (kRows - i)));
    }
    beyond += highest > kSquare;
  }
  const double expected = kSeeds * tests * std::exp(LogChiSquareTail(kSquare, 1.0));
  // Four standard deviations of the count, and what the law leaves out at so low a level.
  EXPECT_NEAR(beyond, expected, 4.0 * std::sqrt(expected) + 0.1 * expected);
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
