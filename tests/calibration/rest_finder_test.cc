#include "calibration/signal/rest_finder.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>
#include <vector>

namespace gyrobench::calibration {
namespace {

struct Found {
  std::vector<double> begins, ends;
  int outliers = 0;
};

template <typename Angle>
Found Watch(Angle angle, double rate_hz, double duration_s) {
  RestFinder finder;
  Found found;
  for (int i = 0; i < duration_s * rate_hz; ++i) {
    const double t = i / rate_hz;
    switch (finder.Add(t, angle(t))) {
      case RestFinder::Change::kRestBegan:
        found.begins.push_back(finder.rest_begin_s());
        break;
      case RestFinder::Change::kRestEnded:
        found.ends.push_back(finder.last_at_rest_s());
        break;
      case RestFinder::Change::kOutlier:
        ++found.outliers;
        break;
      case RestFinder::Change::kNone:
        break;
    }
  }
  return found;
}

// Rest, 0.5 s of motion at 20 deg/s, rest, ... of period 2.5 s.
double StopAndGo(double t) {
  const double cycle = std::floor(t / 2.5), since = t - 2.5 * cycle;
  return 10.0 * cycle + (since > 2.0 ? 20.0 * (since - 2.0) : 0.0);
}

TEST(RestFinder, FindsEveryRestWhateverTheNoiseOfAGoodEncoder) {
  std::mt19937 random(1);
  for (const double sigma : {0.0, 0.002, 0.0075, 0.02}) {
    std::normal_distribution<double> noise(0.0, sigma > 0 ? sigma : 1.0);
    const Found found =
        Watch([&](double t) { return StopAndGo(t) + (sigma > 0 ? noise(random) : 0.0); }, 50, 99.3);
    EXPECT_EQ(found.begins.size(), 40u) << sigma;
    ASSERT_EQ(found.ends.size(), 39u) << sigma;
    for (std::size_t i = 0; i < found.ends.size(); ++i) {
      EXPECT_NEAR(found.begins[i], 2.5 * static_cast<double>(i), 0.021);
      EXPECT_NEAR(found.ends[i], 2.5 * static_cast<double>(i) + 2.0, 0.021);
    }
  }
}

TEST(RestFinder, FindsRestsBetweenTheCountsOfACoarseEncoder) {
  const double count = 360.0 / 4096;
  std::mt19937 random(2);
  std::normal_distribution<double> noise(0.0, 0.02);
  const Found found =
      Watch([&](double t) { return count * std::round((StopAndGo(t) + noise(random)) / count); },
            50, 99.3);
  EXPECT_EQ(found.begins.size(), 40u);
}

TEST(RestFinder, FindsRestsOfAnAxisThatIsReadFiveTimesASecond) {
  const Found found =
      Watch([](double t) { return t < 10   ? 0.0
                                  : t < 12 ? 8 * (t - 10)
                                           : 16.0; }, 5, 30);
  ASSERT_EQ(found.begins.size(), 2u);
  EXPECT_NEAR(found.ends.at(0), 10.0, 0.21);
  EXPECT_NEAR(found.begins.at(1), 12.0, 0.21);
}

TEST(RestFinder, FindsRestsOfAnAxisThatIsReadOnceASecond) {
  const Found found = Watch([](double t) { return t < 10 ? 0.0 : 16.0; }, 1, 30);
  ASSERT_EQ(found.begins.size(), 2u);
  EXPECT_NEAR(found.ends.at(0), 9.0, 0.01);
  EXPECT_NEAR(found.begins.at(1), 10.0, 0.01);
}

TEST(RestFinder, TakesASlowTurnForMotion) {
  EXPECT_TRUE(Watch([](double t) { return 0.5 * t; }, 50, 60).begins.empty());
  EXPECT_TRUE(Watch([](double t) { return 5 * std::sin(1.3 * t); }, 50, 60).begins.empty());
}

TEST(RestFinder, CountsASingleWildReadingInsteadOfEndingTheRest) {
  const Found found =
      Watch([](double t) { return std::fabs(t - 5.0) < 0.005 ? 90.0 : 1.0; }, 50, 10);
  EXPECT_EQ(found.begins.size(), 1u);
  EXPECT_TRUE(found.ends.empty());
  EXPECT_EQ(found.outliers, 1);
}

// A hand that holds the sensor sways to the edge of the tolerance, and noise carries single
// readings over it: nothing is wrong with them.
TEST(RestFinder, TakesNoReadingThatAgreesWithItsNeighboursForAnOutlier) {
  std::mt19937 random(2);
  std::normal_distribution<double> noise(0.0, 0.001);
  for (const double sway_deg : {0.03, 0.04, 0.06}) {
    const Found found =
        Watch([&](double t) { return sway_deg * std::sin(2.0 * t) + noise(random); }, 200, 120.0);
    EXPECT_EQ(found.outliers, 0) << sway_deg;
  }
}

// Readings of one stretch, 50 a second.
template <typename Angle>
OpenRest Read(Angle angle, int readings, double count_deg) {
  constexpr double kStep_s = 0.02;
  OpenRest rest;
  rest.count_deg = count_deg;
  for (int i = 0; i < readings; ++i) {
    const double deg = angle(kStep_s * i);
    rest.Add(kStep_s * i,
             {0.0, 0.0, count_deg > 0 ? count_deg * std::round(deg / count_deg) : deg});
    rest.last_at_rest_s = kStep_s * i;
  }
  return rest;
}

// Of many stretches, how often one of this motion is told from a rest.
template <typename Angle>
double ShareThatDrifts(Angle angle, int readings, double noise_deg, double count_deg) {
  constexpr int kStretches = 400;
  std::mt19937 random(3);
  std::normal_distribution<double> noise(0.0, noise_deg);
  std::uniform_real_distribution<double> place(0.0, 1.0);
  int drift = 0;
  for (int k = 0; k < kStretches; ++k) {
    const double from_deg = place(random);
    const auto read = [&](double t_s) { return from_deg + angle(t_s) + noise(random); };
    drift += Read(read, readings, count_deg).Drifts() ? 1 : 0;
  }
  return static_cast<double>(drift) / kStretches;
}

// Chance alone makes one in a few thousand a drift; two of 400 are less likely than one in a
// hundred.
constexpr double kHardlyEver = 0.005;

TEST(OpenRest, ARestDoesNotDriftWhateverReadsIt) {
  const auto still = [](double) { return 0.0; };
  for (const int readings : {10, 40, 1000}) {
    for (const double count_deg : {0.0, 0.022, 0.088}) {
      for (const double noise_deg : {0.001, 0.01, 0.05})
        EXPECT_LE(ShareThatDrifts(still, readings, noise_deg, count_deg), kHardlyEver)
            << readings << " readings, counts of " << count_deg << ", noise of " << noise_deg;
    }
  }
}

// However large, and wherever in the rest, where there are many readings.
TEST(OpenRest, AStepBetweenTwoLongRestsIsNoDrift) {
  for (const double noise_deg : {0.003, 0.03}) {
    for (const double sigmas : {1.0, 2.0, 3.0, 4.0, 6.0, 20.0}) {
      for (const double at_s : {4.0, 7.0, 10.0}) {
        const auto step = [&](double t_s) { return t_s > at_s ? sigmas * noise_deg : 0.0; };
        EXPECT_LE(ShareThatDrifts(step, 1000, noise_deg, 0.0), kHardlyEver)
            << sigmas << " x " << noise_deg << " deg";
      }
    }
  }
}

// However exactly it is read.
TEST(OpenRest, ATableThatCreepsRests) {
  for (const double rate_deg_s : {1e-4, 0.003, 0.01}) {
    const auto creep = [&](double t_s) { return rate_deg_s * t_s; };
    EXPECT_EQ(ShareThatDrifts(creep, 5000, 0.001, 0.0), 0.0) << rate_deg_s;
  }
}

// By as much as brings it out of the tolerance of a rest: six times the noise on either side, or a
// count and a tenth.
TEST(OpenRest, ATableThatLeavesTheToleranceDrifts) {
  for (const int readings : {20, 50, 100}) {
    const double length_s = 0.02 * readings;
    for (const double noise_deg : {0.005, 0.03}) {
      const auto turn = [&](double t_s) { return 10.0 * noise_deg * t_s / length_s; };
      EXPECT_GE(ShareThatDrifts(turn, readings, noise_deg, 0.0), 0.98) << readings;
    }
    const auto over_counts = [&](double t_s) { return 3.0 * 0.088 * t_s / length_s; };
    EXPECT_GE(ShareThatDrifts(over_counts, readings, 0.002, 0.088), 0.98) << readings;
  }
}

}  // namespace
}  // namespace gyrobench::calibration
