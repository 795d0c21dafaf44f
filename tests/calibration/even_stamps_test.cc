#include "calibration/signal/even_stamps.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <random>
#include <vector>

#include "calibration/signal/collector.h"

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

// An interval of 1.3 to 3.3 digits: 30 to 77 Hz in hundredths of a second.
TEST(EvenStamps, AnEvenClockIsFoundWhereAnIntervalIsHardlyLongerThanADigit) {
  std::mt19937_64 random(9);
  std::uniform_real_distribution<double> any(0.0, 1.0);
  for (const double digit_s : {1e-2, 1e-3}) {
    for (int i = 0; i < 60; ++i) {
      const double digits = 1.3 + 2.0 * any(random), hz = 1.0 / (digits * digit_s);
      // Rounding repeats itself too slowly to tell.
      if (std::fabs(digits - 0.5 * std::round(2.0 * digits)) < 0.03) continue;
      const double start_s = 500.0 * any(random);
      const auto rounded = [=](double t) { return Rounded(t, digit_s); };
      EXPECT_LT(WorstError_s(hz, start_s, rounded, [](int) { return true; }), 0.25 * digit_s) << hz;
      EXPECT_LT(WorstError_s(hz, start_s, rounded, [](int k) { return k < 50 || k % 17 != 5; }),
                0.25 * digit_s)
          << hz;
    }
  }
}

// A clock that is nearly at a whole number of digits: its stamps are exact for up to a minute and
// then step by one digit more or less, which would be a step of the angle.
void ExpectNoSteps(double hz, double digit_s, double most_digits) {
  EvenStamps stamps;
  double last_s = 0.0, worst_s = 0.0, worst_step_s = 0.0;
  for (int i = 0; i / hz < 500.0; ++i) {
    const double t_s = 3.3 + i / hz, mended_s = stamps.Mend(Rounded(t_s, digit_s));
    if (i / hz > 200.0) {
      worst_s = std::max(worst_s, std::fabs(mended_s - t_s));
      worst_step_s = std::max(worst_step_s, std::fabs(mended_s - last_s - 1.0 / hz));
    }
    last_s = mended_s;
  }
  EXPECT_LT(worst_s, most_digits * digit_s) << hz;
  EXPECT_LT(worst_step_s, 0.01 * digit_s) << hz;
}

TEST(EvenStamps, AStepOfADigitOnceAMinuteIsTakenOut) {
  for (const double hz : {49.9, 49.99, 49.995, 50.01, 50.1, 33.34}) ExpectNoSteps(hz, 1e-2, 0.2);
  for (const double part : {20e-6, 50e-6, 200e-6, -20e-6, -50e-6, -200e-6}) {
    for (const double hz : {50.0, 100.0, 200.0}) ExpectNoSteps(hz * (1.0 + part), 1e-3, 0.3);
  }
}

TEST(EvenStamps, TheErrorIsThatOfTheStampsWhereTheyBeatTooSlowlyToTell) {
  EvenStamps stamps;
  for (int i = 0; i < 30000; ++i) {  // of a beat of 100 s
    const double t_s = i / 99.999;
    EXPECT_LT(std::fabs(stamps.Mend(Rounded(t_s, 1e-3)) - t_s), 1.1e-3);
  }
}

TEST(EvenStamps, AClockThatWarmsUpIsNotLeftBehind) {
  for (const double drift : {2e-5, 1e-4, 5e-4}) {
    EvenStamps stamps;
    double t_s = 0.0, sum_s = 0.0, square_s2 = 0.0, last_s = 0.0, worst_step_s = 0.0;
    constexpr int kMany = 60000;
    for (int i = 0; i < kMany; ++i) {
      t_s += (1.0 + drift * std::exp(-t_s / 300.0)) / 100.3;
      const double error_s = stamps.Mend(Rounded(t_s, 1e-3)) - t_s;
      sum_s += error_s;
      square_s2 += error_s * error_s;
      if (i > 1000) worst_step_s = std::max(worst_step_s, std::fabs(error_s - last_s));
      last_s = error_s;
    }
    EXPECT_LT(std::fabs(sum_s / kMany), 2e-5) << drift;
    EXPECT_LT(worst_step_s, 1e-5) << drift;
    EXPECT_LT(std::sqrt(square_s2 / kMany), 1.5e-4) << drift << ": of the stamps 2.9e-4";
  }
}

// Of nearly a whole number of digits, so that the line reaches back over a minute: it is behind by
// a part of a digit, and goes over to the shorter one and back without a step.
TEST(EvenStamps, AClockThatWarmsUpAndBeatsSlowlyMakesNoStep) {
  for (const double drift : {1e-5, 3e-5}) {
    EvenStamps stamps;
    double t_s = 0.0, last_s = 0.0, worst_s = 0.0, worst_step_s = 0.0;
    for (int i = 0; i < 60000; ++i) {
      t_s += (1.0 + drift * std::exp(-t_s / 300.0)) / 100.02;
      const double error_s = stamps.Mend(Rounded(t_s, 1e-3)) - t_s;
      if (i > 2000) {
        worst_s = std::max(worst_s, std::fabs(error_s));
        worst_step_s = std::max(worst_step_s, std::fabs(error_s - last_s));
      }
      last_s = error_s;
    }
    EXPECT_LT(worst_s, 2e-4) << drift;
    EXPECT_LT(worst_step_s, 1e-5) << drift;
  }
}

// A line over so many would be told from the stamps by rounding of the sums alone.
TEST(EvenStamps, AFastGyroKeepsItsLine) {
  EvenStamps stamps;
  double worst_s = 0.0;
  for (int i = 0; i < 600000; ++i) {
    const double t_s = 900.0 + i / 4005.0, mended_s = stamps.Mend(Rounded(t_s, 1e-4));
    if (i > 100000) worst_s = std::max(worst_s, std::fabs(mended_s - t_s));
  }
  EXPECT_LT(worst_s, 1e-6);
}

TEST(EvenStamps, ExactStampsAndThoseOfManyDigitsStayAsTheyAre) {
  std::mt19937_64 random(7);
  std::uniform_real_distribution<double> any(0.0, 1.0);
  EvenStamps exact, fine;
  for (int i = 0; i < 2000; ++i) {
    const double in_digits = Rounded(0.01 * i, 1e-3);
    EXPECT_EQ(exact.Mend(in_digits), in_digits);
    const double in_microseconds = Rounded(0.00997 * i + 2e-6 * any(random), 1e-6);
    EXPECT_EQ(fine.Mend(in_microseconds), in_microseconds);
  }
}

TEST(EvenStamps, AClockThatJittersHasNoWorseTimesThanItsStamps) {
  for (const double jitter_s : {0.5e-3, 0.8e-3, 3e-3}) {
    std::mt19937_64 random(8);
    std::uniform_real_distribution<double> jitter(-jitter_s, jitter_s);
    EvenStamps stamps;
    double mended_s2 = 0.0, stamped_s2 = 0.0, worst_s = 0.0;
    for (int i = 0; i < 20000; ++i) {
      const double t_s = i / 81.3 + jitter(random), stamp_s = Rounded(t_s, 1e-3);
      const double error_s = stamps.Mend(stamp_s) - t_s;
      mended_s2 += error_s * error_s;
      stamped_s2 += std::pow(stamp_s - t_s, 2);
      worst_s = std::max(worst_s, std::fabs(error_s));
    }
    EXPECT_LT(mended_s2, 1.05 * stamped_s2) << jitter_s;
    EXPECT_LT(worst_s, 1.1e-3) << jitter_s;
  }
}

// Of an interval of a few digits: whole digits lie on many lines.
TEST(EvenStamps, JitterIsNoLineWhereAnIntervalHasFewDigits) {
  std::mt19937_64 random(10);
  std::uniform_real_distribution<double> any(0.0, 1.0);
  for (const double part : {0.2, 0.3, 0.4}) {
    std::uniform_real_distribution<double> jitter(-part, part);
    for (int clock = 0; clock < 60; ++clock) {
      const double digits = 2.0 + 4.0 * any(random);  // of a millisecond
      EvenStamps stamps;
      double mended_s2 = 0.0, stamped_s2 = 0.0;
      for (int i = 0; i < 3000; ++i) {
        const double t_s = 1e-3 * digits * (i + jitter(random)), stamp_s = Rounded(t_s, 1e-3);
        mended_s2 += std::pow(stamps.Mend(stamp_s) - t_s, 2);
        stamped_s2 += std::pow(stamp_s - t_s, 2);
      }
      EXPECT_LT(mended_s2, 1.1 * stamped_s2) << digits << " digits, " << part;
    }
  }
}

// A sample that is lost among the first stamps does not spoil the interval for good.
TEST(EvenStamps, AnEvenClockIsFoundSoonAfterALossAtItsBegin) {
  std::mt19937_64 random(11);
  std::uniform_real_distribution<double> any(0.0, 1.0);
  for (int clock = 0; clock < 100; ++clock) {
    const double digits = 2.1 + 1.8 * any(random), hz = 1e3 / digits;
    if (std::fabs(digits - std::round(digits)) < 0.05) continue;
    const int lost = 1 + clock % 6;
    EXPECT_LT(WorstError_s(
                  hz, 10.0 * any(random), [](double t) { return Rounded(t, 1e-3); },
                  [=](int k) { return k != lost; }),
              2.5e-4)
        << digits << " digits, lost " << lost;
  }
}

TEST(EvenStamps, APauseAndAStampThatIsNoNumberDoNoHarm) {
  EvenStamps stamps;
  double start_s = 0.0, last_s = -1.0;
  for (int pause = 0; pause < 20; ++pause, start_s += 37.0 + 0.0123 * pause) {
    for (int i = 0; i < 300; ++i) {
      const double t_s = start_s + i / 100.3, mended_s = stamps.Mend(Rounded(t_s, 1e-3));
      EXPECT_LT(std::fabs(mended_s - t_s), 6e-4);
      EXPECT_GT(mended_s, last_s);
      last_s = mended_s;
      if (i == 100) {
        EXPECT_TRUE(std::isnan(stamps.Mend(std::nan(""))));
      }
    }
  }
}

// Of a reference and a gyro, both in milliseconds: the largest error of the times of the nodes.
double WorstNode_s(double gyro_hz, double reference_hz) {
  constexpr double kDigit_s = 1e-3, kSettled_s = 20.0, kEnd_s = 120.0;
  constexpr double kGyro_s = 0.0137, kReference_s = 0.0411;
  Collector collector;
  MeasurementInfo info;
  info.gyro_present = {false, false, true};
  info.reference = ReferenceKind::kSensorAngle;
  collector.OnInfo(info);
  int sample = 0;
  for (int reading = 0; reading < kEnd_s * reference_hz; ++reading) {
    const double stamp_s = Rounded(kReference_s + reading / reference_hz, kDigit_s);
    for (;; ++sample) {
      const double gyro_s = Rounded(kGyro_s + sample / gyro_hz, kDigit_s);
      if (gyro_s > stamp_s + 1e-9) break;
      collector.OnGyro({.t_s = gyro_s, .xi = {kMissing, kMissing, 0.01 * (sample % 3)}});
    }
    collector.OnAngle({.t_s = stamp_s, .axis = 2, .angle_deg = 0.0});
  }
  double worst_s = 0.0;
  int nodes = 0;
  for (const Node& node : collector.Take().columns.nodes) {
    if (node.at.t_s < kSettled_s) continue;
    ++nodes;
    const double place = (node.at.t_s - kReference_s) * reference_hz;
    worst_s = std::max(worst_s, std::fabs(place - std::round(place)) / reference_hz);
  }
  EXPECT_GT(nodes, 400) << gyro_hz;
  return worst_s;
}

// Stamps of both are the same by chance, of every fifth reading beside a gyro of 200 Hz.
TEST(EvenStamps, AReadingWithTheStampOfASampleKeepsTheTimeOfItsOwnClock) {
  for (const double gyro_hz : {61.7, 199.3, 200.0, 401.0})
    EXPECT_LT(WorstNode_s(gyro_hz, 10.03), 5e-5) << gyro_hz;
}

KnownClock ClockOf(const std::vector<double>& stamps_s) {
  EvenStamps stamps;
  for (const double stamp_s : stamps_s) stamps.Mend(stamp_s);
  return stamps.Clock();
}

std::vector<double> StampsOf(double hz, double digit_s, double length_s) {
  std::vector<double> stamps_s;
  for (double i = 0.0; i / hz < length_s; ++i) stamps_s.push_back(Rounded(3.0 + i / hz, digit_s));
  return stamps_s;
}

// Hundredths of a second beat with these rates once in 1.5 s to more than a minute.
TEST(EvenStamps, ReadOnceMoreAllStampsAreOnTheLineOfTheWhole) {
  constexpr double kDigit_s = 1e-2;
  for (const double hz : {50.34, 40.028, 33.482, 35.715, 50.653}) {
    const std::vector<double> stamps_s = StampsOf(hz, kDigit_s, 200.0);
    const KnownClock clock = ClockOf(stamps_s);
    ASSERT_EQ(clock.first_stamp_s, stamps_s.front()) << hz;
    EvenStamps again(clock);
    double low_s = 1e9, high_s = -1e9, last_s = -1e9;
    for (std::size_t i = 0; i < stamps_s.size(); ++i) {
      const double mended_s = again.Mend(stamps_s[i]);
      EXPECT_GT(mended_s, last_s);
      EXPECT_EQ(again.Mend(stamps_s[i]), mended_s);
      last_s = mended_s;
      const double error_s = mended_s - (3.0 + static_cast<double>(i) / hz);
      low_s = std::min(low_s, error_s);
      high_s = std::max(high_s, error_s);
    }
    EXPECT_LT(high_s - low_s, 0.1 * kDigit_s) << hz;
  }
}

// Where another clock takes over, the known line ends.
TEST(EvenStamps, ALineThatStampsLeaveIsHeldNoLonger) {
  std::vector<double> stamps_s = StampsOf(40.028, 1e-2, 200.0);
  EvenStamps again(ClockOf(stamps_s));
  for (const double stamp_s : stamps_s) again.Mend(stamp_s);
  double worst_s = 0.0;
  for (double i = 1.0; i < 4000.0; ++i) {
    const double t_s = stamps_s.back() + i / 43.7, mended_s = again.Mend(Rounded(t_s, 1e-2));
    ASSERT_TRUE(std::isfinite(mended_s));
    if (i > 500.0) worst_s = std::max(worst_s, std::fabs(mended_s - t_s));
  }
  EXPECT_LT(worst_s, 0.5e-2);
}

TEST(EvenStamps, JitterExactAndFineStampsHaveNoLineOfTheirWhole) {
  std::mt19937_64 random(4);
  std::normal_distribution<double> jitter_s(0.0, 4e-3);
  std::vector<double> jittered_s;
  for (double i = 0.0; i < 8000.0; ++i)
    jittered_s.push_back(Rounded(i / 40.028 + jitter_s(random), 1e-2));
  std::ranges::sort(jittered_s);
  EXPECT_TRUE(std::isnan(ClockOf(jittered_s).interval_s));
  EXPECT_TRUE(std::isnan(ClockOf(StampsOf(50.0, 1e-2, 200.0)).interval_s));
  EXPECT_TRUE(std::isnan(ClockOf(StampsOf(54.77, 1e-3, 200.0)).interval_s));
  EXPECT_TRUE(std::isnan(ClockOf(StampsOf(40.028, 1e-2, 10.0)).interval_s));
}

TEST(EvenStamps, TheSameStampHasTheSameTimeAndAStepBackBeginsAnew) {
  EvenStamps stamps;
  for (int i = 0; i < 500; ++i) {
    const double stamp_s = Rounded(i / 30.0, 1e-3), mended_s = stamps.Mend(stamp_s);
    EXPECT_EQ(stamps.Mend(stamp_s), mended_s);
  }
  EXPECT_EQ(stamps.Mend(3.0), 3.0);
  for (int at = 2; at < 32; ++at) {
    EvenStamps early;
    double last_s = 0.0;
    for (int i = 0; i < at; ++i) early.Mend(last_s = Rounded(7.0 + i / 43.0, 1e-2));
    const double back_s = Rounded(last_s - 0.01, 1e-2);
    EXPECT_EQ(early.Mend(back_s), back_s) << at;
  }
}

}  // namespace
}  // namespace gyrobench::calibration
