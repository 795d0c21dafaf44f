// A slow quantity is smoothed without a bend in it being lost.
#include <gtest/gtest.h>

#include <cmath>
#include <cstdint>
#include <functional>
#include <random>
#include <vector>

#include "calibration/state/slow_quantity.h"

namespace gyrobench::testing {
namespace {

using calibration::SmoothByLines;
using calibration::Smoothed;

constexpr double kHalfWindow_s = 5.0, kStep_s = 0.1, kLength_s = 60.0;

struct Measured {
  std::vector<double> t_s, value;
};

Measured Measure(const std::function<double(double)>& truth, double noise, double count,
                 std::uint64_t seed) {
  std::mt19937_64 random(seed);
  std::normal_distribution<double> normal;
  Measured out;
  for (double t = 0.0; t <= kLength_s; t += kStep_s) {
    double value = truth(t) + noise * normal(random);
    if (count > 0.0) value = count * std::round(value / count);
    out.t_s.push_back(t);
    out.value.push_back(value);
  }
  return out;
}

// A fan starts: two straight lines fitted to the 100 values of a window know the middle to
// 4 sigma^2 / 100 in the mean of all places that the bend may have in it, 16 at its very end.
TEST(ABend, IsNotRoundedOff) {
  constexpr double kNoise = 0.01, kBend_s = 30.03, kBefore = 0.002, kAfter = -0.085;
  auto truth = [](double t) {
    return t < kBend_s ? kBefore * (t - kBend_s) : kAfter * (t - kBend_s);
  };
  double square = 0.0, worst = 0.0;
  int count = 0;
  for (std::uint64_t seed = 1; seed <= 20; ++seed) {
    const Measured measured = Measure(truth, kNoise, 0.0, seed);
    const Smoothed smooth = SmoothByLines(measured.t_s, measured.value, kHalfWindow_s);
    for (std::size_t i = 0; i < measured.t_s.size(); ++i) {
      if (std::fabs(measured.t_s[i] - kBend_s) > 0.5 * kHalfWindow_s) continue;
      const double error = smooth.value[i] - truth(measured.t_s[i]);
      square += error * error;
      worst = std::fmax(worst, std::fabs(error));
      ++count;
    }
  }
  EXPECT_LT(std::sqrt(square / count), 1.2 * kNoise * std::sqrt(4.0 / 100.0));
  // 5 standard errors of the worst place; rounding off would make it 0.05.
  EXPECT_LT(worst, 5.0 * kNoise * std::sqrt(16.0 / 100.0));
}

// What noise makes is no bend: elsewhere the rate is that of a line through the window.
TEST(ABend, IsNotSeenInNoise) {
  constexpr double kNoise = 0.01, kRate = 0.01;
  const double of_line = kNoise * std::sqrt(12.0 / 100.0) / (2.0 * kHalfWindow_s);
  for (std::uint64_t seed = 1; seed <= 20; ++seed) {
    const Measured measured = Measure([](double t) { return kRate * t; }, kNoise, 0.0, seed);
    const Smoothed smooth = SmoothByLines(measured.t_s, measured.value, kHalfWindow_s);
    for (std::size_t i = 60; i + 60 < measured.t_s.size(); ++i)
      ASSERT_NEAR(smooth.rate[i], kRate, 6.0 * of_line) << "seed " << seed;
  }
}

// The steps of a converter are no bends: over a window they err by one count at most.
TEST(ABend, IsNotSeenInTheStepsOfAConverter) {
  constexpr double kCount = 0.01;
  for (const double rate : {0.0007, 0.002, 0.011}) {
    const Measured measured = Measure([&](double t) { return rate * t; }, 0.0, kCount, 1);
    const Smoothed smooth = SmoothByLines(measured.t_s, measured.value, kHalfWindow_s);
    for (std::size_t i = 60; i + 60 < measured.t_s.size(); ++i) {
      ASSERT_NEAR(smooth.value[i], rate * measured.t_s[i], kCount) << "rate " << rate;
      ASSERT_NEAR(smooth.rate[i], rate, 2.0 * kCount / (2.0 * kHalfWindow_s)) << "rate " << rate;
    }
  }
}

TEST(ASmoothCurve, KeepsItsSlopeWithoutNoise) {
  auto truth = [](double t) { return 20.0 + 0.3 * t - 0.002 * t * t; };
  const Measured measured = Measure(truth, 0.0, 0.0, 1);
  const Smoothed smooth = SmoothByLines(measured.t_s, measured.value, kHalfWindow_s);
  for (std::size_t i = 60; i + 60 < measured.t_s.size(); ++i) {
    ASSERT_NEAR(smooth.value[i], truth(measured.t_s[i]), 1e-6);
    ASSERT_NEAR(smooth.rate[i], 0.3 - 0.004 * measured.t_s[i], 1e-6);
  }
}

}  // namespace
}  // namespace gyrobench::testing
