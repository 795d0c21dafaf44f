// What is counted of a line: every transaction once, in the span in which it ended.
#include "drivers/line_figures.h"

#include <gmock/gmock.h>

#include <algorithm>
#include <cmath>
#include <random>
#include <vector>

#include "tests/drivers/bus_bench.h"

namespace gyrobench::drivers {
namespace {

constexpr Utime kSecond = kMicrosecondsPerSecond;

TEST(Latencies, AQuantileIsWithinATenthOfThatOfTheSortedTimes) {
  std::mt19937_64 random(5);
  std::lognormal_distribution<double> time_us(9.0, 1.0);
  Latencies latencies;
  std::vector<double> sorted;
  for (int i = 0; i < 5000; ++i) {
    const double time = std::round(time_us(random)) + 1.0;
    latencies.Add(static_cast<Utime>(time));
    sorted.push_back(1e-6 * time);
  }
  std::ranges::sort(sorted);
  for (const double share : {0.01, 0.25, 0.5, 0.9, 0.99}) {
    const double expected = sorted[static_cast<std::size_t>(share * 5000.0)];
    EXPECT_NEAR(latencies.Quantile_s(share) / expected, 1.0, 0.11) << share;
  }
  EXPECT_EQ(latencies.count(), 5000);
}

TEST(Latencies, OfNoneThereIsNoQuantile) { EXPECT_TRUE(std::isnan(Latencies().Quantile_s(0.5))); }

TEST(Latencies, TimesBelowAMicrosecondAndBeyondAMinuteHaveAPlace) {
  Latencies latencies;
  latencies.Add(0);
  latencies.Add(1000 * kSecond);
  EXPECT_EQ(latencies.count(), 2);
  EXPECT_LT(latencies.Quantile_s(0.4), 2e-6);
  EXPECT_GT(latencies.Quantile_s(1.0), 30.0);
}

TEST(LineRecorder, SpansAddUpToAll) {
  LineRecorder recorder(kStart);
  for (int i = 0; i < 20; ++i)
    recorder.Add("gyro", 21, kStart + i * kSecond, {.latency_us = 1000, .busy_us = 2000});
  const LineFigures figures = recorder.Figures(kStart + 20 * kSecond);
  ASSERT_EQ(figures.all.size(), 1U);
  EXPECT_EQ(figures.all[0].transactions, 20);
  EXPECT_EQ(figures.all[0].busy_us, 40'000);
  EXPECT_EQ(figures.recent[0].transactions, 20);
  EXPECT_EQ(figures.utime_recent, kStart);
}

TEST(LineRecorder, WhatIsLongAgoIsNotRecent) {
  LineRecorder recorder(kStart);
  recorder.Add("gyro", 21, kStart, {.tries = 3, .silent = 3, .given_up = true});
  recorder.Add("gyro", 21, kStart + 40 * kSecond, {});
  recorder.Add("gyro", 21, kStart + 55 * kSecond, {});
  const LineFigures figures = recorder.Figures(kStart + 56 * kSecond);
  EXPECT_EQ(figures.all[0].given_up, 1);
  EXPECT_EQ(figures.recent[0].given_up, 0);
  EXPECT_EQ(figures.recent[0].transactions, 2);
  EXPECT_EQ(recorder.Figures(kStart + 500 * kSecond).recent[0].transactions, 0);
  // One more after a long pause: what was before it is as long ago.
  recorder.Add("gyro", 21, kStart + 600 * kSecond, {});
  const LineFigures later = recorder.Figures(kStart + 601 * kSecond);
  EXPECT_EQ(later.recent[0].transactions, 1);
  EXPECT_LE(later.utime_now - later.utime_recent, 30 * kSecond);
}

TEST(LineRecorder, UnitsAreApartByNumberAndName) {
  LineRecorder recorder(kStart);
  recorder.Add("axis.inner drive", 3, kStart, {});
  recorder.Add("axis.inner encoder", 13, kStart, {});
  recorder.Add("axis.inner drive", 3, kStart, {});
  const LineFigures figures = recorder.Figures(kStart + kSecond);
  ASSERT_EQ(figures.all.size(), 2U);
  EXPECT_EQ(figures.all[0].transactions, 2);
  EXPECT_EQ(figures.all[1].device, "axis.inner encoder");
}

class FiguresOfABus : public testing::TestWithParam<Transport> {};

TEST_P(FiguresOfABus, EachEndIsCountedAsWhatItWas) {
  BusBench bench(GetParam());
  bench.Read();
  bench.line.Inject(LineFault::kBadChecksum);
  bench.Read();
  bench.line.Inject(LineFault::kException, 2);
  EXPECT_NE(bench.ReadFailure(), "");
  bench.line.Inject(LineFault::kLostRequest, 0, 2);
  EXPECT_NE(bench.ReadFailure(), "");
  const LineFigures figures = bench.bus->Figures();
  ASSERT_EQ(figures.all.size(), 1U);
  const UnitFigures& unit = figures.all[0];
  EXPECT_EQ(unit.device, kUnit.name);
  EXPECT_EQ(unit.unit, kUnit.unit);
  EXPECT_EQ(unit.transactions, 4);
  EXPECT_EQ(unit.retries, 2);
  EXPECT_EQ(unit.unreadable, 1);
  EXPECT_EQ(unit.refused, 1);
  EXPECT_EQ(unit.silent, 2);
  EXPECT_EQ(unit.line_lost, 0);
  EXPECT_EQ(unit.given_up, 2);
  EXPECT_EQ(unit.latencies.count(), 2);
  EXPECT_EQ(figures.bus, "A");
}

TEST_P(FiguresOfABus, ALineThatIsGoneIsNoSilentDevice) {
  BusBench bench(GetParam());
  bench.Read();
  bench.line.Unplug();
  EXPECT_NE(bench.ReadFailure(), "");
  const UnitFigures unit = bench.bus->Figures().all.at(0);
  EXPECT_EQ(unit.given_up, 1);
  EXPECT_GT(unit.line_lost, 0);
}

INSTANTIATE_TEST_SUITE_P(OnEach, FiguresOfABus, testing::Values(Transport::kRtu, Transport::kTcp));

}  // namespace
}  // namespace gyrobench::drivers
