// A step of the reference while the table rests.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <random>
#include <string>
#include <vector>

#include "calibration/signal/collector.h"
#include "calibration/state/history_parts.h"
#include "calibration/trace/trace.h"
#include "tests/calibration/synthetic_bench.h"
#include "tests/calibration/trace_once.h"

namespace gyrobench::testing {
namespace {

calibration::ChannelTrace TraceOfRun(const Motion& motion, const Injection& injection,
                                     std::uint64_t seed) {
  return TraceOf(SyntheticBench(motion).Measure(injection, seed));
}

Motion Turns() {
  Motion motion;
  motion.Rest(20);
  for (const double rate : {10.0, 20.0, 40.0}) motion.ThereAndBack(kInnerAxis, 180, rate);
  return motion;
}

struct Rested {
  Motion motion;
  double step_s = 0.0;
};
Rested WithAStepAtRest(double rest_s) {
  Rested out{Turns(), 0.0};
  out.step_s = out.motion.duration_s() + 0.4 * rest_s;
  out.motion.Rest(rest_s);
  for (const double rate : {10.0, 20.0, 40.0}) out.motion.ThereAndBack(kInnerAxis, 180, rate);
  return out;
}

constexpr double kIdleStep_s = 45.0;

class StepAtRest : public ::testing::TestWithParam<double> {};

TEST_P(StepAtRest, IsOneStepOfItsSizeAtItsTime) {
  const Rested told = WithAStepAtRest(GetParam());
  const Injection step{
      {}, [&](const BenchState& s) { return s.t_s >= told.step_s ? 0.05 : 0.0; }, {}};
  const calibration::ChannelTrace channel = TraceOfRun(told.motion, step, 5);
  ASSERT_EQ(channel.effects.size(), 1U) << channel.summary;
  EXPECT_EQ(channel.effects[0].id, "angle.step");
  for (const calibration::ModelParameter& parameter : channel.effects[0].parameters) {
    if (parameter.name == "b_inner") {
      EXPECT_NEAR(parameter.value, 0.05, 4.0 * parameter.std_error);
      EXPECT_LT(parameter.std_error, 0.01);
    }
    if (parameter.name == "t0") {
      EXPECT_NEAR(parameter.value, told.step_s, 0.3);
    }
  }
}
INSTANTIATE_TEST_SUITE_P(Rests, StepAtRest, ::testing::Values(4.0, 20.0, 120.0));

// 200 s at rest: the inner axis is read 50 times a second, the outer 5 times.
calibration::Recording RestsWithAnIdleAxis(std::uint64_t seed, double outer_step_deg) {
  std::mt19937_64 random(seed);
  std::normal_distribution<double> noise(0.0, 0.005);
  MeasurementInfo info;
  info.gyro_present = {false, false, true};
  info.gyro_units_per_deg_s = 131.0;
  info.reference = ReferenceKind::kStandAngles;
  info.stand_axis_present = {true, false, true};
  calibration::Collector collector;
  collector.OnInfo(info);
  for (int i = 0; i < 100 * 200; ++i) {
    const double t_s = 0.01 * i;
    const double outer_deg = t_s < kIdleStep_s ? 0.0 : outer_step_deg;
    if (i % 2 == 0) collector.OnAngle({t_s, 2, noise(random)});
    if (i % 20 == 5) collector.OnAngle({t_s, 0, outer_deg + noise(random)});
    GyroSample sample;
    sample.t_s = t_s + 0.003;
    sample.xi = {kMissing, kMissing, 20.0 * noise(random)};
    collector.OnGyro(sample);
  }
  return collector.Take();
}

// Of an axis: where the clear steps are in stretches of so many nodes.
std::vector<double> ClearSteps(const calibration::Recording& recording, std::size_t axis,
                               std::size_t length) {
  const std::vector<calibration::Node>& nodes = recording.columns.nodes;
  std::vector<calibration::NodeRange> rests;
  for (std::size_t k = 0; k + length <= nodes.size(); k += length) rests.push_back({k, k + length});
  const calibration::StepLimits limits = {recording.reference_step_deg[axis],
                                          calibration::ScatterAtRest(nodes, rests, axis)};
  std::vector<double> steps;
  for (const calibration::NodeRange& rest : rests) {
    if (const auto step = calibration::LargestStep(nodes, rest, axis, limits))
      steps.push_back(nodes[step->at].at.t_s);
  }
  return steps;
}

// An axis that is idle is read less often, and what was read last is held in between: held values
// are no readings, and say nothing of its noise.
TEST(ARestWithAnIdleAxis, HasNoStepInItsNoise) {
  for (std::uint64_t seed = 1; seed <= 20; ++seed) {
    const calibration::Recording recording = RestsWithAnIdleAxis(seed, 0.0);
    for (const std::size_t length : {20u, 300u}) {
      EXPECT_THAT(ClearSteps(recording, 0, length), ::testing::IsEmpty()) << "outer, seed " << seed;
      EXPECT_THAT(ClearSteps(recording, 2, length), ::testing::IsEmpty()) << "inner, seed " << seed;
    }
  }
}

TEST(ARestWithAnIdleAxis, ShowsAStepThatIsThere) {
  for (std::uint64_t seed = 1; seed <= 20; ++seed) {
    const calibration::Recording recording = RestsWithAnIdleAxis(seed, 0.05);
    EXPECT_THAT(ClearSteps(recording, 0, 300),
                ::testing::ElementsAre(::testing::DoubleNear(kIdleStep_s, 0.5)));
  }
}

TEST(Rest, WithoutAStepIsOneRest) {
  for (std::uint64_t seed = 1; seed <= 5; ++seed) {
    const Rested told = WithAStepAtRest(60.0);
    EXPECT_TRUE(TraceOfRun(told.motion, {}, seed).effects.empty()) << seed;
  }
}

}  // namespace
}  // namespace gyrobench::testing
