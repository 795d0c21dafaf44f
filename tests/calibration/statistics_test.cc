#include "calibration/gls/statistics.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>
#include <vector>

namespace gyrobench::calibration {
namespace {

TEST(Statistics, StudentsIntervalIsTheOneOfTheTables) {
  EXPECT_NEAR(StudentHalfWidth(1), 12.706, 1e-3);
  EXPECT_NEAR(StudentHalfWidth(10), 2.228, 1e-3);
  EXPECT_NEAR(StudentInflation(1e9), 1.0, 1e-12);
  EXPECT_NEAR(StudentHalfWidth(std::nan("")), 1.96, 1e-3)
      << "nothing known: as if the noise were known";
}

// Under white noise the p-value is uniform: 2000 draws, at 5 sigma.
TEST(Statistics, WhitenessPValueIsUniformForWhiteNoise) {
  std::mt19937 random(1);
  std::normal_distribution<double> normal;
  int below = 0;
  const int trials = 2000;
  for (int trial = 0; trial < trials; ++trial) {
    std::vector<double> v(300);
    for (double& x : v) x = normal(random);
    below += WhitenessPValue(v, 10) < 0.1 ? 1 : 0;
  }
  EXPECT_NEAR(below, 0.1 * trials, 5 * std::sqrt(0.09 * trials));
}

TEST(Statistics, WhitenessPValueIsSmallForCorrelatedNoise) {
  std::mt19937 random(1);
  std::normal_distribution<double> normal;
  std::vector<double> v(500);
  for (std::size_t i = 1; i < v.size(); ++i) v[i] = 0.4 * v[i - 1] + normal(random);
  EXPECT_LT(WhitenessPValue(v, 10), 1e-6);
}

TEST(Statistics, StandardErrorOfAMeanNeedsTwo) {
  const std::vector<double> one = {1.0}, three = {1.0, 2.0, 3.0};
  EXPECT_TRUE(std::isnan(MeanStdError(one)));
  EXPECT_NEAR(MeanStdError(three), 1.0 / std::sqrt(3.0), 1e-15);
}

}  // namespace
}  // namespace gyrobench::calibration
