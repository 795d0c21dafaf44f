// The model that a trace ends with: baseline, effects of one power-on and of one run, the names of
// its numbers, and no effect where there is none.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <vector>

#include "calibration/effects/effect.h"
#include "calibration/state/state_history.h"
#include "calibration/trace/problem.h"
#include "calibration/trace/trace.h"
#include "tests/calibration/injected.h"
#include "tests/calibration/synthetic_bench.h"
#include "tests/calibration/trace_once.h"

namespace gyrobench::testing {
namespace {

using calibration::ChannelTrace;
using calibration::TracedEffect;

// The row of M is no effect but part of what every trace estimates.
TEST(Baseline, RecoversTheCrossAxisTermsAndTheScaleFactorWithinTheirIntervals) {
  const SyntheticBench bench(EveryMotion());
  const ChannelTrace channel = TraceOf(bench.Measure({}, 11), 1);
  EXPECT_THAT(NamesOf(channel), ::testing::IsEmpty());
  const std::array<double, 3>& m = bench.sensor().m_row;
  for (const Expected& expected :
       {Expected{"cross_axis_zx", m[0]}, {"cross_axis_zy", m[1]}, {"scale_factor", m[2]}}) {
    ExpectWithinItsInterval(channel.baseline.parameters, expected);
  }
}

// A step of the offset acts in one power-on of two: its columns there are those rows of its columns
// in all, which are 0 elsewhere.
TEST(ColumnsOfOnePowerOn, AreTheRowsOfThoseInWhichTheyAct) {
  const calibration::Recording recording = SyntheticBench(ManySpeeds()).Measure({}, 3);
  const auto history = [&] {
    return calibration::MakeStateHistory(recording, {kMissing, kMissing, 1.0}, true, {});
  };
  const std::array<calibration::StateHistory, 2> histories = {history(), history()};
  const calibration::ChannelProblem problem(histories, 2, 1.0);
  const calibration::Effect& step =
      calibration::ScannedEffect(calibration::Search::kTime, calibration::EffectDomain::kRate);
  calibration::BasisContext context;
  context.nonlinear = {30.0};
  for (std::size_t power_on = 0; power_on < 2; ++power_on) {
    const Eigen::Index begin = problem.begin_of(power_on), end = problem.end_of(power_on);
    const Eigen::MatrixXd all = problem.Columns(step, context, power_on);
    EXPECT_EQ(problem.ColumnsIn(power_on, step, context), all.middleRows(begin, end - begin));
    EXPECT_GT(all.norm(), 0.0);
    EXPECT_EQ(all.topRows(begin).norm() + all.bottomRows(all.rows() - end).norm(), 0.0);
  }
}

// What is late in one run of two is one effect, of the run that it is in, in whatever order the two
// are given and whatever their power-ons are called.
TEST(ALatency, OfOneOfTwoRunsIsOfThatRunInAnyOrder) {
  const SyntheticBench bench(EveryMotion());
  for (const char* name : {"0", "zz"}) {
    const calibration::Recording late = bench.Measure(Latency(bench), 7);
    calibration::Recording prompt = bench.Measure({}, 8);
    prompt.info.power_on = name;
    for (const double late_is : {1.0, 2.0}) {
      const bool first = late_is == 1.0;
      const calibration::Recording* const inputs[] = {first ? &late : &prompt,
                                                      first ? &prompt : &late};
      const ChannelTrace channel = TraceOf(inputs, 1);
      ASSERT_THAT(NamesOf(channel), ::testing::ElementsAre("angle.latency_of_run"))
          << channel.summary << ", power-on " << name;
      ExpectWithinItsInterval(channel.effects[0].parameters, {"tau", 0.012});
      ExpectWithinItsInterval(channel.effects[0].parameters, {"run", late_is, 0.1});
    }
  }
}

// Of two runs one alone turns: what is late there is late.
TEST(ALatency, OfTheOnlyRunThatTurnsIsNoMatterOfThatRun) {
  const SyntheticBench turning(EveryMotion()), resting(Motion().Rest(120.0));
  calibration::Recording rest = resting.Measure({}, 8);
  rest.info.power_on = "before";
  const calibration::Recording turns = turning.Measure(Latency(turning), 7);
  const calibration::Recording* const inputs[] = {&rest, &turns};
  const ChannelTrace channel = TraceOf(inputs, 1);
  EXPECT_THAT(NamesOf(channel), ::testing::ElementsAre("angle.latency")) << channel.summary;
  ASSERT_EQ(channel.effects.size(), 1u);
  EXPECT_THAT(channel.effects[0].rivals, ::testing::IsEmpty());
}

// With a declared delay the baseline has a column of the filter's shape: the names of the
// covariance are those of the numbers all the same.
TEST(TheModel, NamesEachVarianceByTheParameterThatItIsOf) {
  const SyntheticBench bench(EveryMotion());
  calibration::Recording recording =
      bench.Measure(Rate([](const BenchState& s) { return 0.05 * s.g[0] - 0.08 * s.g[1]; }), 7);
  recording.info.gyro_delay_s = 0.004;
  const calibration::Recording* const inputs[] = {&recording};
  const calibration::Traced traced = calibration::Trace(inputs);
  const ChannelTrace& channel = traced.result.channels.at(0);
  const calibration::ChannelModel& model = traced.models.at(0);
  ASSERT_THAT(NamesOf(channel), ::testing::Contains("bias.g_linear")) << channel.summary;
  std::vector<calibration::ModelParameter> all = channel.baseline.parameters;
  for (const TracedEffect& effect : channel.effects)
    for (calibration::ModelParameter parameter : effect.parameters) {
      parameter.name = effect.id + "." + parameter.name;
      all.push_back(parameter);
    }
  EXPECT_THAT(model.parameter_names, ::testing::Contains("filter_shape"));
  EXPECT_THAT(model.parameter_names, ::testing::Each(::testing::Not(::testing::IsEmpty())));
  int compared = 0;
  for (const calibration::ModelParameter& parameter : all) {
    const auto name = std::ranges::find(model.parameter_names, parameter.name);
    if (name == model.parameter_names.end()) continue;
    const auto i = static_cast<std::size_t>(name - model.parameter_names.begin());
    // Nobody says where the bench is: what may be the Earth's rotation is beside the fit's own.
    const double statistical = parameter.statistical_std_error, both = parameter.std_error;
    const double earth = std::isnan(statistical) ? 0.0 : both * both - statistical * statistical;
    EXPECT_NEAR(std::sqrt(model.covariance.at(i * model.parameter_names.size() + i)),
                std::hypot(parameter.bound, std::sqrt(earth)), 1e-9 * both)
        << parameter.name;
    ++compared;
  }
  EXPECT_EQ(compared, static_cast<int>(model.parameter_names.size()));
}

// What never turned has no scale factor, and its calibration says none.
TEST(TheModel, OfRestsAloneHasNoScaleFactor) {
  const calibration::Recording recording = SyntheticBench(Motion().Rest(120.0)).Measure({}, 8);
  const calibration::Recording* const inputs[] = {&recording};
  EXPECT_THAT(calibration::Trace(inputs).models.at(0).m_row, ::testing::Each(0.0));
}

TEST(NoEffect, IsNamedInTwentyOfTwentyMeasurementsThatHaveNone) {
  const SyntheticBench bench(ManySpeeds());
  for (std::uint64_t seed = 100; seed < 120; ++seed) {
    const ChannelTrace channel = TraceOf(bench.Measure({}, seed), seed);
    EXPECT_THAT(NamesOf(channel), ::testing::IsEmpty()) << "seed " << seed;
  }
}

}  // namespace
}  // namespace gyrobench::testing
