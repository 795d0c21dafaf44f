// A step of the reference while the table rests.
#include <gtest/gtest.h>

#include <cmath>
#include <string>
#include <vector>

#include "calibration/trace/trace.h"
#include "tests/calibration/synthetic_bench.h"

namespace gyrobench::testing {
namespace {

calibration::ChannelTrace TraceOf(const Motion& motion, const Injection& injection,
                                  std::uint64_t seed) {
  const calibration::Recording recording = SyntheticBench(motion).Measure(injection, seed);
  const calibration::Recording* const inputs[] = {&recording};
  calibration::TraceOptions options;
  options.curves = false;
  return calibration::Trace(inputs, options).result.channels.at(0);
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

class StepAtRest : public ::testing::TestWithParam<double> {};

TEST_P(StepAtRest, IsOneStepOfItsSizeAtItsTime) {
  const Rested told = WithAStepAtRest(GetParam());
  const Injection step{
      {}, [&](const BenchState& s) { return s.t_s >= told.step_s ? 0.05 : 0.0; }, {}};
  const calibration::ChannelTrace channel = TraceOf(told.motion, step, 5);
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

TEST(Rest, WithoutAStepIsOneRest) {
  for (std::uint64_t seed = 1; seed <= 5; ++seed) {
    const Rested told = WithAStepAtRest(60.0);
    EXPECT_TRUE(TraceOf(told.motion, {}, seed).effects.empty()) << seed;
  }
}

}  // namespace
}  // namespace gyrobench::testing
