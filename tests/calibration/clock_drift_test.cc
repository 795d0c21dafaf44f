// Clocks of gyro and reference that part: the readings are put on one clock, and that they parted
// is found with its number and with nothing beside it.
#include "calibration/signal/clock_drift.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <functional>
#include <numbers>
#include <random>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "calibration/signal/clock_offset.h"
#include "calibration/signal/collector.h"
#include "calibration/state/state_history.h"
#include "calibration/trace/problem.h"
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
  out.shown_s = [=](double t_s) { return t_s + 1e-6 * drift_ppm * t_s + latency_s; };
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
  return OnOneClock(std::move(as_stamped), 0.0,
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
    EXPECT_TRUE(found.matters) << drift_ppm;
    EXPECT_NEAR(found.drift_ppm, drift_ppm, 0.1 * std::fabs(drift_ppm) + 4.0 * found.std_error_ppm);
    recordings.front() = Read(bench, Late(drift_ppm), 1, drift_ppm);
    const ClockDrift left = FindClockDrift(recordings);
    EXPECT_LT(std::fabs(left.drift_ppm), 4.0 * left.std_error_ppm) << drift_ppm;
    EXPECT_FALSE(left.matters);
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

// What is no drift: nothing at all, or a delay that stays; and where nothing turns, nothing is
// known. Four standard errors by chance are 6e-5 a time.
TEST(ClockDrift, IsNotSeenWhereThereIsNone) {
  const SyntheticBench bench(EveryMotion());
  for (std::uint64_t seed = 1; seed <= 10; ++seed) {
    for (const double latency_s : {0.0, 0.03}) {
      std::vector<Recording> recordings;
      recordings.push_back(Read(bench, Late(0.0, latency_s), seed, 0.0));
      const ClockDrift found = FindClockDrift(recordings);
      EXPECT_FALSE(found.matters) << seed << ": " << found.drift_ppm << " ppm";
      EXPECT_LT(std::fabs(found.drift_ppm), 4.0 * found.std_error_ppm) << seed;
      EXPECT_LT(found.std_error_ppm, 50.0);
    }
  }
  std::vector<Recording> at_rest;
  at_rest.push_back(Read(SyntheticBench(Motion().Rest(60.0)), Late(300.0), 1, 0.0));
  EXPECT_TRUE(std::isinf(FindClockDrift(at_rest).std_error_ppm));
  EXPECT_TRUE(std::isinf(FindClockDrift({}).std_error_ppm));
}

// To and fro in periods of 8 s, from `begin_s` on the gyro's clock. The reference's begins with it.
Recording Swing(double begin_s, double drift_ppm, double corrected_ppm) {
  constexpr double kDuration_s = 300.0, kPeriod_s = 8.0, kSwing_deg = 50.0;
  constexpr double kW = 2.0 * std::numbers::pi / kPeriod_s;
  MeasurementInfo info;
  info.gyro_present = {false, false, true};
  info.gyro_unit = RateUnit::kDegPerSecond;
  info.gyro_units_per_deg_s = 1.0;
  info.reference = ReferenceKind::kStandAngles;
  info.stand_axis_present = {false, false, true};
  EvenRows clocks;
  clocks.reference_drift_ppm = corrected_ppm;
  Collector collector(Collector::kNode_s, clocks);
  collector.OnInfo(info);
  std::mt19937_64 random(7);
  std::normal_distribution<double> normal;
  for (int n = 0; n * 0.01 < kDuration_s; ++n) {
    GyroSample sample;
    sample.t_s = begin_s + n * 0.01;
    sample.xi = {kMissing, kMissing, kSwing_deg * kW * std::sin(kW * n * 0.01)};
    collector.OnGyro(sample);
    if (n % 2 != 0) continue;
    const double shown_s = n * 0.01 * (1.0 + 1e-6 * drift_ppm);
    collector.OnAngle(
        {sample.t_s, 2, -kSwing_deg * std::cos(kW * shown_s) + 0.003 * normal(random)});
  }
  return collector.Take();
}
std::vector<Recording> Swings(double begin_s, const std::vector<double>& drifts_ppm,
                              double corrected_ppm) {
  std::vector<Recording> out;
  for (const double drift_ppm : drifts_ppm) out.push_back(Swing(begin_s, drift_ppm, corrected_ppm));
  return out;
}

// A power-on hours before, or a clock of the world: nothing is moved where it begins.
TEST(ClockDrift, CountsFromWhereTheMeasurementBegins) {
  for (const double begin_s : {0.0, 10000.0, 1.7e9}) {
    const ClockDrift found = FindClockDrift(Swings(begin_s, {100.0}, 0.0));
    EXPECT_TRUE(found.matters) << begin_s;
    EXPECT_NEAR(found.drift_ppm, 100.0, 5.0) << begin_s;
    const std::vector<Recording> out =
        OnOneClock(Swings(begin_s, {100.0}, 0.0), 0.0,
                   [&](double ppm) { return Swings(begin_s, {100.0}, ppm); });
    EXPECT_NEAR(out.front().drift_correction.drift_ppm, 100.0, 5.0) << begin_s;
    EXPECT_NEAR(out.front().columns.nodes.front().at.t_s, begin_s, 0.2) << begin_s;
    EXPECT_EQ(RemarkOnClocks(out.front()), "") << begin_s;
  }
}

TEST(ClockDrift, OfTwoLoggersThatDisagreeLeavesBothAsTheyAre) {
  const auto corrected_ppm = [](double one_ppm, double other_ppm) {
    const std::vector<Recording> out =
        OnOneClock(Swings(0.0, {one_ppm, other_ppm}, 0.0), 0.0, [&](double ppm) {
          return Swings(0.0, {one_ppm, other_ppm}, ppm);
        });
    return out.front().drift_correction.drift_ppm;
  };
  EXPECT_NEAR(corrected_ppm(200.0, 200.0), 200.0, 5.0);
  EXPECT_EQ(corrected_ppm(300.0, 0.0), 0.0);
}

TEST(ClockDrift, ReadingsThatDoNotComeToRestStayAsTheyWereStamped) {
  const SyntheticBench bench(EveryMotion());
  std::vector<Recording> as_stamped;
  as_stamped.push_back(Read(bench, Late(300.0), 1, 0.0));
  int reads = 0;
  const std::vector<Recording> out = OnOneClock(std::move(as_stamped), 0.0, [&](double) {
    ++reads;
    std::vector<Recording> no_better;
    no_better.push_back(Read(bench, Late(300.0), 1, 0.0));
    no_better.back().drift_correction.drift_ppm = 1.0;
    return no_better;
  });
  EXPECT_GT(reads, 1);
  EXPECT_EQ(out.front().drift_correction.drift_ppm, 0.0);
}

// Of a channel, which must not see what was done to the readings.
struct Rows {
  explicit Rows(const Recording& recording)
      : history(MakeStateHistory(recording, {kMissing, kMissing, 1.0}, true, {})),
        problem(std::span(&history, 1), 2, 1.0) {}
  StateHistory history;
  ChannelProblem problem;
};

// Rows of the same readings in both: pairs of their numbers. Nodes are on a grid of times, on which
// corrected readings go on a little faster or slower.
std::vector<std::pair<Eigen::Index, Eigen::Index>> OfTheSameReadings(const ChannelProblem& one,
                                                                     const ChannelProblem& other) {
  constexpr double kSame_s = 1e-4;
  const auto begin_s = [](const ChannelProblem& problem, Eigen::Index row) {
    const auto interval = problem.row_refs()[static_cast<std::size_t>(row)].interval;
    return problem.history(row).nodes[interval].stamp_s();
  };
  const auto end_s = [](const ChannelProblem& problem, Eigen::Index row) {
    return problem.end_node(row).stamp_s();
  };
  std::vector<std::pair<Eigen::Index, Eigen::Index>> pairs;
  Eigen::Index j = 0;
  for (Eigen::Index i = 0; i < one.rows(); ++i) {
    while (j < other.rows() && end_s(other, j) < end_s(one, i) - kSame_s) ++j;
    if (j < other.rows() && std::fabs(end_s(other, j) - end_s(one, i)) < kSame_s &&
        std::fabs(begin_s(other, j) - begin_s(one, i)) < kSame_s)
      pairs.emplace_back(i, j);
  }
  return pairs;
}

// Row by row the output is that of the readings as they were stamped, whatever the delay makes of a
// ramp; and so is the column of a delay, be it the drift or not.
TEST(TheProblem, IsThatOfTheReadingsAsTheyWereStamped) {
  constexpr double kDrift_ppm = 500.0;
  const SyntheticBench bench(EveryMotion());
  const Recording stamped = Read(bench, Late(kDrift_ppm), 4, 0.0);
  const Recording corrected = Read(bench, Late(kDrift_ppm), 4, kDrift_ppm);
  const Rows before(stamped), after(corrected);
  const auto pairs = OfTheSameReadings(before.problem, after.problem);
  ASSERT_GT(pairs.size(), 300U);
  // Norms of what differs and of the first, over the same readings.
  const auto share = [&](const Eigen::VectorXd& one, const Eigen::VectorXd& other) {
    double differs = 0.0, square = 0.0;
    for (const auto& [i, j] : pairs) {
      differs += std::pow(one(i) - other(j), 2);
      square += std::pow(one(i), 2);
    }
    return std::sqrt(differs / square);
  };
  const Eigen::VectorXd output = after.problem.output_deg();
  EXPECT_GT(share(before.problem.output_deg(), output - after.problem.DriftCorrection_deg()), 0.04);
  EXPECT_LT(share(before.problem.output_deg(), output), 0.01);
  for (const double latency_s : {-0.05, 1e-9, 0.02, 0.15}) {
    BasisContext context;
    context.nonlinear = {latency_s};
    const Effect& latency = *FindEffect("angle.latency");
    EXPECT_LT(share(before.problem.Columns(latency, context).col(0),
                    after.problem.Columns(latency, context).col(0)),
              0.01)
        << latency_s;
  }
}

struct Case {
  double drift_ppm, latency_s;
};

// 500 ppm are 0.15 s at the end: more than a quarter of a ramp.
TEST(TheTrace, NamesClocksThatPartWithTheirNumberAndNothingBeside) {
  const SyntheticBench bench(EveryMotion());
  for (const Case& each : {Case{500.0, 0.0}, {-200.0, 0.0}, {300.0, 0.012}, {-300.0, 0.04}}) {
    const Injection late = Late(each.drift_ppm, each.latency_s);
    const Recording recording = OnOneClockOf(bench, late, 3);
    EXPECT_NE(recording.drift_correction.drift_ppm, 0.0);
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
  // Without the effect the rates about a ramp are those of another time.
  EXPECT_NEAR(before_deg[1] / before_deg[0], 1.0, 0.05);
  EXPECT_NEAR(before_deg[2] / before_deg[1], 1.0, 0.01);
}

// Channels that feel the axis by their cross-axis parts alone have no drift of their own left over.
TEST(TheTrace, OfThreeChannelsHasNothingElse) {
  BenchSensor sensor;
  sensor.three_channels = true;
  const SyntheticBench bench(EveryMotion(), sensor);
  const Recording recording = OnOneClockOf(bench, Late(-300.0), 2);
  EXPECT_NEAR(recording.drift_correction.drift_ppm, -300.0, 10.0);
  const TraceResult result = TraceAll(recording);
  ASSERT_EQ(result.channels.size(), 3U);
  std::size_t named = 0;
  for (const ChannelTrace& channel : result.channels) {
    for (const std::string& name : NamesOf(channel)) {
      EXPECT_EQ(name, "angle.clock_drift");
      ++named;
    }
  }
  EXPECT_GE(named, 1U);
}

}  // namespace
}  // namespace gyrobench::calibration
