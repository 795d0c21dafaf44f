#include "procedures/engine/dry_bench.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "procedures/engine/motion_time.h"
#include "tests/procedures/fake_bench.h"

namespace gyrobench::procedures {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::StartsWith;

Plan Dry(const std::string& body, const DryOptions& options = {}) {
  return DryRun(Script(body), {}, ThreeAxes(), options);
}

std::string Refusal(const std::string& body, const DryOptions& options = {}) {
  return MessageOf<LimitError>([&] { Dry(body, options); });
}

TEST(MoveDuration, AgreesWithAMoveStepByStep) {
  for (const double angle : {0.01, 1.0, -9.0, 360.0}) {
    for (const double rate : {0.5, 5.0, 40.0}) {
      FakeBench bench;
      const double stepped = bench.Turn({"inner", angle, rate, 80.0}).duration_s;
      EXPECT_NEAR(MoveDuration_s(angle, rate, 80.0), stepped, 2e-3 + 1e-4 * stepped)
          << angle << " deg at " << rate;
    }
  }
}

TEST(MoveDuration, IsContinuousWhereTheRateIsJustReached) {
  const double angle = 20.0 * 20.0 / 80.0;
  EXPECT_NEAR(MoveDuration_s(angle - 1e-9, 20.0, 80.0), MoveDuration_s(angle + 1e-9, 20.0, 80.0),
              1e-6);
}

TEST(DryRun, RefusesMotionBeyondALimitWithLineValueAndLimit) {
  const std::vector<std::pair<std::string, std::string>> cases = {
      {"angle_deg=412, rate_deg_s=9", "axis.inner: 412 deg is beyond the soft limit 360 deg"},
      {"angle_deg=-361, rate_deg_s=9", "axis.inner: -361 deg is beyond the soft limit -360 deg"},
      {"shaft_turns=41, rate_deg_s=9", "axis.inner: 369 deg is beyond the soft limit 360 deg"},
      {"angle_deg=9, rate_deg_s=41", "axis.inner: 41 deg/s is beyond the rate limit 40 deg/s"},
      {"angle_deg=9, rate_deg_s=0", "axis.inner: rate 0 deg/s: expected a number above 0"},
      {"angle_deg=9, rate_deg_s=-5", "axis.inner: rate -5 deg/s: expected a number above 0"},
      {"angle_deg=9, rate_deg_s=9, acceleration_deg_s2=81",
       "axis.inner: 81 deg/s^2 is beyond the acceleration limit 80 deg/s^2"},
      {"angle_deg=9, rate_deg_s=9, acceleration_deg_s2=0", "acceleration 0 deg/s^2"},
  };
  for (const auto& [fields, message] : cases) {
    EXPECT_THAT(Refusal("\n\nbench.turn{axis='inner', " + fields + "}"),
                AllOf(StartsWith("try.lua:4: "), HasSubstr(message)))
        << fields;
  }
}

TEST(DryRun, RefusesAnAxisThatTheStandDoesNotHave) {
  EXPECT_THAT(
      Refusal("bench.turn{axis='upper', angle_deg=1, rate_deg_s=1}"),
      StartsWith("try.lua:2: axis.upper: this stand has no such axis, it has: outer, middle"));
}

TEST(DryRun, FollowsTheAngleThroughManyMoves) {
  const std::string loop =
      "for i = 1, 41 do\nbench.turn{axis='inner', angle_deg=9, rate_deg_s=9}\nend";
  EXPECT_THAT(Refusal(loop), StartsWith("try.lua:3: axis.inner: 369 deg is beyond"));
  EXPECT_EQ(Dry("for i = 1, 40 do bench.turn{axis='inner', angle_deg=9, rate_deg_s=9} end")
                .moves.back()
                .to_deg,
            360.0);
}

TEST(DryRun, AllowsTheWayBackInsideFromBeyondALimit) {
  std::vector<AxisFacts> axes = ThreeAxes();
  axes[2].angle_deg = 400.0;
  const auto turn = [&](double angle) {
    DryBench bench(axes);
    bench.Turn({"inner", angle, 9.0, 9.0});
  };
  EXPECT_NO_THROW(turn(-50.0));
  EXPECT_THROW(turn(-10.0), LimitError);
  EXPECT_THROW(turn(10.0), LimitError);
}

TEST(CheckTurn, LetsNothingThroughThatIsNotANumber) {
  const AxisFacts axis = ThreeAxes()[2];
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const double inf = std::numeric_limits<double>::infinity();
  for (const double bad : {nan, inf, -inf}) {
    EXPECT_THROW(CheckTurn({"inner", bad, 9, 9}, axis), LimitError);
    EXPECT_THROW(CheckTurn({"inner", 9, bad, 9}, axis), LimitError);
    EXPECT_THROW(CheckTurn({"inner", 9, 9, bad}, axis), LimitError);
    EXPECT_THROW(CheckRest(bad), LimitError);
  }
  AxisFacts lost = axis;
  lost.angle_deg = nan;
  EXPECT_THROW(CheckTurn({"inner", 9, 9, 9}, lost), LimitError);
}

// Stops scatter: a plan that ends on the limit must not be refused half way on the live bench.
TEST(CheckTurn, HasSlackOnALiveTableOnly) {
  AxisFacts axis = ThreeAxes()[2];
  axis.angle_deg = 351.03;
  EXPECT_NO_THROW(CheckTurn({"inner", 9, 9, 9}, axis));
  EXPECT_THROW(CheckTurn({"inner", 9, 9, 9}, axis, 0.0), LimitError);
}

TEST(DryRun, AddsUpTimeSegmentsAndMoves) {
  const Plan plan =
      Dry("bench.rest{duration_s=5}\nbench.turn{axis='outer', angle_deg=-10, rate_deg_s=10,"
          "acceleration_deg_s2=50}\nbench.soak{max_s=600}");
  ASSERT_EQ(plan.segments.size(), 3U);
  EXPECT_EQ(plan.segments[0].begin_s, 0.0);
  for (std::size_t i = 1; i < 3; ++i) {
    EXPECT_EQ(plan.segments[i].begin_s, plan.segments[i - 1].end_s);
  }
  EXPECT_EQ(plan.segments[1].kind, "turn");
  EXPECT_DOUBLE_EQ(plan.segments[1].end_s, 6.2);
  EXPECT_EQ(plan.segments[2].kind, "soak");
  EXPECT_DOUBLE_EQ(plan.duration_s, 606.2);
  ASSERT_EQ(plan.moves.size(), 1U);
  EXPECT_EQ(plan.moves[0].from_deg, 1.0);
  EXPECT_EQ(plan.moves[0].to_deg, -9.0);
}

TEST(DryRun, ExpectsSoaksBetweenTheirWindowAndTheirEnd) {
  const Plan cold = Dry("bench.soak{max_s=36000, drift_degC=0.1, window_s=120}");
  EXPECT_EQ(cold.duration_s, 36000.0);
  EXPECT_GT(cold.expected_duration_s, 120.0);
  EXPECT_LT(cold.expected_duration_s, 5000.0);
  const Plan twice = Dry("for i = 1, 2 do bench.soak{max_s=36000} end");
  EXPECT_NEAR(twice.expected_duration_s, cold.expected_duration_s + 120.0, 1e-6);
  EXPECT_EQ(Dry("bench.soak{max_s=200}").expected_duration_s, 200.0);
  EXPECT_EQ(Dry("bench.soak{max_s=20000, min_s=10000}").expected_duration_s, 10000.0);
}

TEST(DryRun, TellsTheScriptTheTimeThatItExpectsASoakToTake) {
  const Plan plan =
      Dry("local s = bench.soak{max_s=36000, drift_degC=0.3, window_s=60}\n"
          "bench.say(string.format('%.3f', s.duration_s))");
  ASSERT_EQ(plan.notes.size(), 1u);
  EXPECT_NEAR(std::stod(plan.notes[0]), plan.expected_duration_s, 1e-3);
}

// The expectation solves room - cold exp(-t/tau): at that time the change within the window is the
// drift.
TEST(DryRun, ExpectsASoakToEndWhenItsTemperatureSettles) {
  const DryOptions options;
  const double t = Dry("bench.soak{max_s=36000, drift_degC=0.3, window_s=60}").expected_duration_s;
  const auto temperature = [&](double time_s) {
    return options.room_degC - options.cold_degC * std::exp(-time_s / options.time_constant_s);
  };
  EXPECT_NEAR(temperature(t) - temperature(t - 60.0), 0.3, 1e-9);
}

TEST(DryRun, AnswersQuestionsAtNoCost) {
  const Plan plan =
      Dry("assert(bench.ask{id='a', text='t', choices={'x','y'}} == 'x')\n"
          "assert(bench.ask{id='b', text='t'} == '')\n"
          "assert(bench.ask{id='c', text='t', choices={'x','y'}} == 'y')",
          {.answers = {{"c", "y"}}});
  EXPECT_EQ(plan.duration_s, 0.0);
  EXPECT_EQ(plan.questions.size(), 3U);
  EXPECT_FALSE(plan.questions[0].configured_answer);
  EXPECT_EQ(plan.questions[2].configured_answer, "y");
}

TEST(DryRun, KnowsWhenTheOperatorIsNeeded) {
  const std::string soak = "bench.soak{max_s=36000, drift_degC=0.3, window_s=60}\n";
  const Plan plan =
      Dry("bench.rest{duration_s=70}\n" + soak + "bench.ask{id='fan', text='Fan on?'}");
  ASSERT_EQ(plan.questions.size(), 1U);
  EXPECT_EQ(plan.questions[0].question.text, "Fan on?");
  EXPECT_EQ(plan.questions[0].at_s, plan.expected_duration_s);
  EXPECT_LT(plan.questions[0].at_s, plan.duration_s);
}

TEST(DryRun, HasEstimatesFromTheStart) {
  Dry("local e = bench.estimate('scale_factor') assert(e.value > 0 and e.std_error == 0)\n"
      "assert(bench.estimate('bias').unit == 'LSB')");
}

TEST(DryRun, AWaitForATemperatureComesToAnEnd) {
  EXPECT_LT(Dry("while bench.temperature() < 20 do bench.rest{duration_s=60} end").duration_s,
            3600.0);
}

TEST(DryRun, RefusesARunBeyondADayWithTheLineThatGoesBeyond) {
  EXPECT_THAT(Refusal("while true do\nbench.rest{duration_s=3600}\nend"),
              AllOf(StartsWith("try.lua:3: the run would take 90000 s"), HasSubstr("86400 s")));
}

TEST(DryRun, RefusesMoreSegmentsThanItsBudget) {
  EXPECT_THAT(Refusal("while true do bench.rest{duration_s=1e-6} end", {.max_segments = 50}),
              HasSubstr("more than 50 segments"));
}

TEST(DryRun, LimitsOfThePartDoNotRefuseARun) {
  EXPECT_NO_THROW(Dry("bench.limit{name='x', value=5, max=1}"));
}

}  // namespace
}  // namespace gyrobench::procedures
