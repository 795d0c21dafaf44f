// Products of two quantities: one effect where one number makes them so, looked for where the data
// can tell them from others.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include "calibration/state/state_history.h"
#include "calibration/trace/candidate.h"
#include "calibration/trace/problem.h"
#include "calibration/trace/trace.h"
#include "tests/calibration/injected.h"
#include "tests/calibration/synthetic_bench.h"
#include "tests/calibration/trace_once.h"

namespace gyrobench::testing {
namespace {

using calibration::ChannelTrace;

// |w| (T - T0) is |w| T and a part of |w|, an asymmetry, however the product is counted.
TEST(AProductOfTemperature, IsOneEffectCountedFromWhereItIsNothing) {
  const SyntheticBench bench(EveryMotion());
  for (const double share : {0.3, 0.7}) {
    double low = bench.At(0.0).temperature_degC, high = low;
    for (double t_s = 0.0; t_s < bench.motion().duration_s(); t_s += 1.0) {
      low = std::min(low, bench.At(t_s).temperature_degC);
      high = std::max(high, bench.At(t_s).temperature_degC);
    }
    const double origin_degC = low + share * (high - low);
    const calibration::Recording recording =
        bench.Measure(Rate([=](const BenchState& s) {
                        return 3e-4 * std::fabs(Wz(s)) * (s.temperature_degC - origin_degC);
                      }),
                      7);
    const calibration::Recording* const inputs[] = {&recording};
    const calibration::Traced traced = calibration::Trace(inputs, {});
    const ChannelTrace& channel = traced.result.channels.at(0);
    ASSERT_THAT(NamesOf(channel), ::testing::ElementsAre("composed(abs_w*T)")) << channel.summary;
    ExpectWithinItsInterval(channel.effects[0].parameters, {"c", 3e-4});
    ExpectWithinItsInterval(channel.effects[0].parameters, {"T0", origin_degC});
    const calibration::ModelTerm& term = traced.models.at(0).terms.at(0);
    EXPECT_EQ(term.offsets.at(1), channel.effects[0].parameters.at(1).value);
  }
}

// The three parts of a sensitivity to gravity agree in one temperature; where it is none that the
// data have, the sensitivity that is left is an effect of its own.
TEST(AProductOfTemperature, IsOneEffectOnlyWithinTheTemperaturesOfTheData) {
  const SyntheticBench bench(EveryMotion());
  for (const double origin_degC : {bench.At(60.0).temperature_degC, -20.0}) {
    const calibration::Recording recording =
        bench.Measure(Rate([=](const BenchState& s) {
                        return (4e-3 * s.g[0] - 6e-3 * s.g[1] + 2e-3 * s.g[2]) *
                               (s.temperature_degC - origin_degC);
                      }),
                      7);
    const std::vector<std::string> names = NamesOf(TraceOf(recording, 1));
    if (origin_degC > 0.0) {
      EXPECT_THAT(names, ::testing::ElementsAre("composed(g*T)"));
    } else {
      EXPECT_THAT(names, ::testing::Contains("bias.g_linear"));
    }
  }
}

// The same of a voltage. A product with gravity along one axis alone is counted from another
// voltage by a sensitivity to gravity, which is one effect with three coefficients.
TEST(AProductOfACovariate, IsOneEffectCountedFromWhereItIsNothing) {
  const SyntheticBench bench(EveryMotion());
  for (const double origin_v : {4.95, 5.08}) {
    const calibration::Recording recording = bench.Measure(
        Rate([=](const BenchState& s) { return 0.2 * s.g[1] * (s.supply_v - origin_v); }), 7, true);
    const calibration::Recording* const inputs[] = {&recording};
    const calibration::Traced traced = calibration::Trace(inputs, {});
    const ChannelTrace& channel = traced.result.channels.at(0);
    ASSERT_THAT(NamesOf(channel), ::testing::ElementsAre("composed(g_y*supply_v)"))
        << channel.summary;
    ExpectWithinItsInterval(channel.effects[0].parameters, {"c", 0.2});
    ExpectWithinItsInterval(channel.effects[0].parameters, {"supply_v_0", origin_v});
    const calibration::ModelTerm& term = traced.models.at(0).terms.at(0);
    EXPECT_EQ(term.offsets.at(1), channel.effects[0].parameters.at(1).value);
  }
}

// A sensitivity to gravity that no voltage of the data takes away is an effect of its own.
TEST(AProductOfACovariate, IsOneEffectOnlyWithinTheValuesOfTheData) {
  const calibration::Recording recording =
      SyntheticBench(EveryMotion())
          .Measure(Rate([](const BenchState& s) { return 0.2 * s.g[1] * (s.supply_v - 4.5); }), 7,
                   true);
  EXPECT_THAT(NamesOf(TraceOf(recording)),
              ::testing::UnorderedElementsAre("bias.g_linear", "composed(g_y*supply_v)"));
}

// A sensitivity to gravity is not looked for where the table hardly tilts: a coefficient of
// hundreds of deg/s/g made something of the last digits of a direction.
TEST(AProductOfTemperature, IsNotLookedForWhereGravityStays) {
  for (const bool tilts : {false, true}) {
    const calibration::Recording recording =
        SyntheticBench(tilts ? EveryMotion() : ManySpeeds()).Measure({}, 3);
    const calibration::StateHistory history =
        calibration::MakeStateHistory(recording, {kMissing, kMissing, 1.0}, true, {});
    const calibration::ChannelProblem problem({&history, 1}, 2, 1.0);
    const calibration::CandidateSet all = calibration::AllCandidates(problem, {}, true);
    EXPECT_EQ(std::ranges::count(all.grid, "composed(g*T)", &calibration::Candidate::id),
              tilts ? 1 : 0);
  }
}

// Along x and z gravity takes all its values, but one of the two is always level.
TEST(AProductOfGravity, IsNotLookedForWhereItStays) {
  Motion motion;
  motion.Rest(8.0).ThereAndBack(kInnerAxis, 200.0, 20.0).Turn(kMiddleAxis, 90.0, 20.0);
  motion.ThereAndBack(kInnerAxis, 200.0, 20.0).Turn(kMiddleAxis, -90.0, 20.0).Rest(8.0);
  const calibration::Recording recording = SyntheticBench(motion).Measure({}, 3);
  const calibration::StateHistory history =
      calibration::MakeStateHistory(recording, {kMissing, kMissing, 1.0}, true, {});
  const calibration::ChannelProblem problem({&history, 1}, 2, 1.0);
  const calibration::CandidateSet all = calibration::AllCandidates(problem, {}, true);
  const auto listed = [&](const char* id) {
    return std::ranges::count(all.products, id, &calibration::Candidate::id);
  };
  EXPECT_EQ(listed("composed(g_x*g_z)"), 0);
  EXPECT_EQ(listed("composed(g_y*g_z)"), 1);
}

}  // namespace
}  // namespace gyrobench::testing
