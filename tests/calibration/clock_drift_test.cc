// Clocks of gyro and reference that part: the readings are put on one clock, and that they parted
// is found with its number and with nothing beside it.
#include "calibration/signal/clock_drift.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <functional>
#include <string>
#include <utility>
#include <vector>

#include "calibration/signal/collector.h"
#include "tests/calibration/injected.h"
#include "tests/calibration/synthetic_bench.h"
#include "tests/calibration/trace_once.h"

namespace gyrobench::calibration {
namespace {

using gyrobench::testing::BenchSensor;
using gyrobench::testing::BenchState;
using gyrobench::testing::EveryMotion;
using gyrobench::testing::ExpectWithinItsInterval;
using gyrobench::testing::Injection;
using gyrobench::testing::Motion;
using gyrobench::testing::NamesOf;
using gyrobench::testing::SyntheticBench;
using gyrobench::testing::TraceAll;
using gyrobench::testing::TraceOf;

// The gyro is late by latency_s and by drift_ppm of the time: a reading shows what it will see
// then.
Injection Late(double drift_ppm, double latency_s = 0.0) {
  Injection out;
  out.shown_s = [=](double t_s) { return t_s + PartedBy_s(drift_ppm, t_s) + latency_s; };
  return out;
}

Recording Read(const SyntheticBench& bench, const Injection& injection, std::uint64_t seed,
               double drift_ppm) {
  return bench.Measure(injection, seed, false, drift_ppm);
}

// As `gyrobench trace` reads a table.
Recording OnOneClockOf(const SyntheticBench& bench, const Injection& injection,
                       std::uint64_t seed) {
  std::vector<Recording> as_stamped;
  as_stamped.push_back(Read(bench, injection, seed, 0.0));
  return OnOneClock(std::move(as_stamped),
                    [&](double drift_ppm) {
                      std::vector<Recording> again;
                      again.push_back(Read(bench, injection, seed, drift_ppm));
                      return again;
                    })
      .front();
}

TEST(ClockDrift, IsFoundInEitherSenseAndIsGoneOnceItIsPutRight) {
  const SyntheticBench bench(EveryMotion());
  for (const double drift_ppm : {-500.0, -100.0, 100.0, 500.0}) {
    std::vector<Recording> recordings;
    recordings.push_back(Read(bench, Late(drift_ppm), 1, 0.0));
    const ClockDrift found = FindClockDrift(recordings);
    EXPECT_TRUE(found.Matters()) << drift_ppm;
    EXPECT_NEAR(found.drift_ppm, drift_ppm, 0.1 * std::fabs(drift_ppm) + 4.0 * found.std_error_ppm);
    recordings.front() = Read(bench, Late(drift_ppm), 1, drift_ppm);
    const ClockDrift left = FindClockDrift(recordings);
    EXPECT_LT(std::fabs(left.drift_ppm), 4.0 * left.std_error_ppm) << drift_ppm;
    EXPECT_FALSE(left.Matters());
  }
}

// A step of the angle that no clock makes, an axis that lost its count.
TEST(ClockDrift, StandsALostCount) {
  const SyntheticBench bench(EveryMotion());
  Injection injection = Late(300.0);
  injection.angle_deg = [](const BenchState& s) { return s.t_s > 100.0 ? 5.0 : 0.0; };
  std::vector<Recording> recordings;
  recordings.push_back(Read(bench, injection, 1, 0.0));
  const ClockDrift found = FindClockDrift(recordings);
  EXPECT_NEAR(found.drift_ppm, 300.0, 30.0 + 4.0 * found.std_error_ppm);
}

// What is no drift: nothing at all, a delay that stays, a lag of the gyro's filter; and where
// nothing turns, nothing is known. The odds of ten standard errors by chance are nil.
TEST(ClockDrift, IsNotSeenWhereThereIsNone) {
  const SyntheticBench bench(EveryMotion());
  for (std::uint64_t seed = 1; seed <= 10; ++seed) {
    for (const double latency_s : {0.0, 0.03}) {
      std::vector<Recording> recordings;
      recordings.push_back(Read(bench, Late(0.0, latency_s), seed, 0.0));
      const ClockDrift found = FindClockDrift(recordings);
      EXPECT_FALSE(found.Matters()) << seed << ": " << found.drift_ppm << " ppm";
      EXPECT_LT(found.std_error_ppm, 50.0);
    }
  }
  std::vector<Recording> at_rest;
  at_rest.push_back(Read(SyntheticBench(Motion().Rest(60.0)), Late(300.0), 1, 0.0));
  EXPECT_TRUE(std::isinf(FindClockDrift(at_rest).std_error_ppm));
  EXPECT_TRUE(std::isinf(FindClockDrift({}).std_error_ppm));
}

TEST(ClockDrift, ReadingsThatDoNotComeToRestStayAsTheyWereStamped) {
  const SyntheticBench bench(EveryMotion());
  std::vector<Recording> as_stamped;
  as_stamped.push_back(Read(bench, Late(300.0), 1, 0.0));
  int reads = 0;
  const std::vector<Recording> out = OnOneClock(std::move(as_stamped), [&](double) {
    ++reads;
    std::vector<Recording> no_better;
    no_better.push_back(Read(bench, Late(300.0), 1, 0.0));
    no_better.back().reference_drift_ppm = 1.0;
    return no_better;
  });
  EXPECT_GT(reads, 1);
  EXPECT_EQ(out.front().reference_drift_ppm, 0.0);
}

struct Case {
  double drift_ppm, latency_s;
};

// 500 ppm are 0.15 s at the end: more than a quarter of a ramp.
TEST(TheTrace, NamesClocksThatPartWithTheirNumberAndNothingBeside) {
  const SyntheticBench bench(EveryMotion());
  for (const Case& each : {Case{500.0, 0.0}, {-200.0, 0.0}, {300.0, 0.012}}) {
    const Injection late = Late(each.drift_ppm, each.latency_s);
    const Recording recording = OnOneClockOf(bench, late, 3);
    EXPECT_NE(recording.reference_drift_ppm, 0.0);
    const ChannelTrace channel = TraceOf(recording);
    std::vector<std::string> expected = {"angle.clock_drift"};
    if (each.latency_s != 0.0) expected.push_back("angle.latency");
    std::vector<std::string> names = NamesOf(channel);
    std::ranges::sort(names);
    ASSERT_EQ(names, expected) << each.drift_ppm;
    for (const TracedEffect& effect : channel.effects) {
      if (effect.id == "angle.clock_drift")
        ExpectWithinItsInterval(effect.parameters, {"eps", each.drift_ppm});
      else
        ExpectWithinItsInterval(effect.parameters, {"tau", each.latency_s});
    }
  }
}

// What the trace says of a drift does not depend on how much of it was put right before.
TEST(TheTrace, SaysTheSameHoweverMuchWasPutRight) {
  const SyntheticBench bench(EveryMotion());
  std::vector<double> eps, before_deg;
  for (const double put_right_ppm : {0.0, 50.0, 60.0}) {
    const ChannelTrace channel = TraceOf(Read(bench, Late(55.0), 5, put_right_ppm));
    ASSERT_EQ(NamesOf(channel), std::vector<std::string>{"angle.clock_drift"}) << put_right_ppm;
    eps.push_back(channel.effects.front().parameters.front().value);
    before_deg.push_back(channel.fitted_angle_rms_deg.before);
  }
  EXPECT_NEAR(eps[1], eps[0], 0.2);
  EXPECT_NEAR(eps[2], eps[1], 0.2);
  // Which intervals pass for rest differs a little.
  EXPECT_NEAR(before_deg[1] / before_deg[0], 1.0, 0.1);
  EXPECT_NEAR(before_deg[2] / before_deg[1], 1.0, 0.01);
}

// Channels that feel the axis by their cross-axis parts alone have no drift of their own left over.
TEST(TheTrace, OfThreeChannelsHasNothingElse) {
  BenchSensor sensor;
  sensor.three_channels = true;
  const SyntheticBench bench(EveryMotion(), sensor);
  const TraceResult result = TraceAll(OnOneClockOf(bench, Late(-300.0), 2));
  ASSERT_EQ(result.channels.size(), 3U);
  for (const ChannelTrace& channel : result.channels) {
    for (const std::string& name : NamesOf(channel)) EXPECT_EQ(name, "angle.clock_drift");
  }
}

}  // namespace
}  // namespace gyrobench::calibration
