#include "calibration/signal/even_stamps.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <random>
#include <vector>

namespace gyrobench::calibration {
namespace {

double Rounded(double t_s, double digit_s) { return std::round(t_s / digit_s) * digit_s; }

// Of a clock from its 100th sample on, the largest error of the mended times, their mean apart.
double WorstError_s(double hz, double start_s, const std::function<double(double)>& stamp_of,
                    const std::function<bool(int)>& is_there) {
  EvenStamps stamps;
  double low_s = 1e9, high_s = -1e9, last_s = -1e9;
  for (int i = 0, seen = 0; seen < 3000; ++i) {
    if (!is_there(i)) continue;
    const double t_s = start_s + i / hz, mended_s = stamps.Mend(stamp_of(t_s));
    EXPECT_GT(mended_s, last_s);
    last_s = mended_s;
    if (++seen < 100) continue;
    low_s = std::min(low_s, mended_s - t_s);
    high_s = std::max(high_s, mended_s - t_s);
  }
  return 0.5 * (high_s - low_s);
}

TEST(EvenStamps, AnEvenClockIsFoundBehindRoundedStamps) {
  std::mt19937_64 random(6);
  const auto all = [](int) { return true; };
  std::uniform_real_distribution<double> any(0.0, 1.0);
  for (int i = 0; i < 40; ++i) {
    const double hz = 12.0 + 300.0 * any(random), start_s = 500.0 * any(random);
    EXPECT_LT(WorstError_s(
                  hz, start_s, [](double t) { return Rounded(t, 1e-3); }, all),
              2e-4)
        << hz;
    // Digits that are cut off, and samples that are lost.
    EXPECT_LT(WorstError_s(
                  hz, start_s, [](double t) { return std::floor(t * 1e3) / 1e3; },
                  [](int k) { return k % 17 != 5 && k % 400 > 20; }),
              2e-4)
        << hz;
  }
}

TEST(EvenStamps, TheErrorIsThatOfTheStampsWhereTheyBeatTooSlowlyToTell) {
  const auto all = [](int) { return true; };
  const double error_s = WorstError_s(
      99.999, 0.0, [](double t) { return Rounded(t, 1e-3); }, all);
  EXPECT_LT(error_s, 5.1e-4);
}

TEST(EvenStamps, ExactStampsAndThoseOfManyDigitsStayAsTheyAre) {
  std::mt19937_64 random(7);
  std::uniform_real_distribution<double> any(0.0, 1.0);
  EvenStamps exact, fine;
  double t_s = 0.0;
  for (int i = 0; i < 2000; ++i) {
    const double in_digits = Rounded(0.01 * i, 1e-3);
    EXPECT_EQ(exact.Mend(in_digits), in_digits);
    t_s += 0.005 + 0.01 * any(random);
    EXPECT_EQ(fine.Mend(t_s), t_s);
  }
}

TEST(EvenStamps, AClockThatJittersByMoreThanItsDigitStaysAsItIs) {
  std::mt19937_64 random(8);
  std::uniform_real_distribution<double> jitter(-0.003, 0.003);
  EvenStamps stamps;
  for (int i = 0; i < 5000; ++i) {
    const double stamp_s = Rounded(0.0123 * i + jitter(random), 1e-3);
    EXPECT_EQ(stamps.Mend(stamp_s), stamp_s);
  }
}

TEST(EvenStamps, TheSameStampHasTheSameTimeAndAStepBackBeginsAnew) {
  EvenStamps stamps;
  for (int i = 0; i < 500; ++i) {
    const double stamp_s = Rounded(i / 30.0, 1e-3), mended_s = stamps.Mend(stamp_s);
    EXPECT_EQ(stamps.Mend(stamp_s), mended_s);
  }
  EXPECT_EQ(stamps.Mend(3.0), 3.0);
}

}  // namespace
}  // namespace gyrobench::calibration
