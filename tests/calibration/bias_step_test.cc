// A zero-rate offset that jumps while the table turns. The node at which it is looked for first is
// a tenth of a second off at most: what the jump makes of that time is an angle, and no step of it.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <string>

#include "tests/calibration/synthetic_bench.h"
#include "tests/calibration/trace_once.h"
#include "tests/calibration/trace_story.h"

namespace gyrobench::testing {
namespace {

using calibration::ChannelTrace;
using calibration::TracedEffect;

TEST(AJumpOfTheOffset, IsOneStepAtItsTimeBetweenTheNodes) {
  constexpr double kJump_deg_s = 0.3;
  const SyntheticBench bench(ManySpeeds());
  for (const double off_s : {0.0, 0.03, 0.05, 0.08}) {
    const double jump_s = std::floor(0.6 * bench.motion().duration_s()) + off_s;
    Injection jump;
    jump.rate_deg_s = [=](const BenchState& s) { return s.t_s >= jump_s ? kJump_deg_s : 0.0; };
    const ChannelTrace channel = TraceOf(bench.Measure(jump, 3));
    ASSERT_EQ(channel.effects.size(), 1u) << channel.summary << ", at " << jump_s;
    const TracedEffect& effect = channel.effects[0];
    EXPECT_EQ(effect.id, "bias.step") << channel.summary;
    EXPECT_NEAR(effect.parameters[0].value, kJump_deg_s,
                5.0 * effect.parameters[0].std_error + 0.02 * kJump_deg_s);
    EXPECT_NEAR(effect.parameters[1].value, jump_s, 0.012);
  }
}

// Beside play, whose crossings are felt by the gyro less its offset: after the jump that is another
// than at the rest before.
TEST(AJumpOfTheOffset, BesidePlayIsOneStep) {
  constexpr double kJump_deg_s = 0.3, kPlay_deg = 0.04;
  const SyntheticBench bench(ManySpeeds());
  for (const double share : {0.35, 0.6, 0.8}) {
    const double jump_s = std::floor(share * bench.motion().duration_s()) + 0.06;
    for (std::uint64_t seed = 1; seed <= 3; ++seed) {
      Injection both;
      both.rate_deg_s = [=](const BenchState& s) { return s.t_s >= jump_s ? kJump_deg_s : 0.0; };
      both.angle_deg = [follower_deg = 0.0](const BenchState& s) mutable {
        const double angle_deg = s.table.angle_deg[kInnerAxis];
        follower_deg =
            std::clamp(follower_deg, angle_deg - 0.5 * kPlay_deg, angle_deg + 0.5 * kPlay_deg);
        return angle_deg - follower_deg;
      };
      const ChannelTrace channel = TraceOf(bench.Measure(both, seed));
      ASSERT_EQ(channel.effects.size(), 2u) << channel.summary << ", " << jump_s << ", " << seed;
      for (const TracedEffect& effect : channel.effects) {
        const double truth = effect.id == "bias.step" ? kJump_deg_s : kPlay_deg;
        EXPECT_TRUE(effect.id == "bias.step" || effect.id == "angle.backlash") << channel.summary;
        EXPECT_NEAR(effect.parameters[0].value, truth,
                    5.0 * effect.parameters[0].std_error + 0.02 * truth);
      }
    }
  }
}

// Where the temperature only rises, play of a hysteresis is taken up along a straight line of the
// temperature and stays: its name is more than the line.
TEST(AHysteresis, ThatIsCrossedOnceIsNamed) {
  constexpr double kPlay_degC = 1.6, kSlope_deg_s_degC = 0.06, kFrom_degC = 22.0;
  Story story;
  story.UseTurningChannelAlone();
  story.duration_s = 600.0;
  story.white_deg_s = 0.05;
  story.temperature_degC = [=](double t_s) {
    return kFrom_degC + 10.0 * (1.0 - std::exp(-t_s / 240.0));
  };
  story.spoil_gyro = [=, warm = story.temperature_degC](GyroSample* sample) {
    const double taken_up_degC = std::min(warm(sample->t_s) - kFrom_degC, kPlay_degC);
    sample->xi[2] -= 131.0 * kSlope_deg_s_degC * taken_up_degC;
    return true;
  };
  const ChannelTrace channel = TraceOf(story.Collect());
  ASSERT_EQ(channel.effects.size(), 1u) << channel.summary;
  const TracedEffect& effect = channel.effects[0];
  EXPECT_EQ(effect.id, "bias.hysteresis") << channel.summary;
  EXPECT_NEAR(effect.parameters[0].value, kSlope_deg_s_degC, 5.0 * effect.parameters[0].std_error);
  EXPECT_NEAR(effect.parameters[1].value, kPlay_degC, 0.3);
}

// The reading of an axis that stands still jumps while another turns. To the channel that would
// feel it turn, that is an offset that comes and goes.
TEST(AReadingThatJumps, IsNoPairOfStepsOfTheOffset) {
  constexpr double kJump_deg = 0.1;
  BenchSensor sensor;
  sensor.three_channels = true;
  const SyntheticBench bench(ManySpeeds(), sensor);
  for (const double share : {0.4, 0.6}) {
    const double jump_s = std::floor(share * bench.motion().duration_s()) + 0.03;
    Injection jump;
    jump.axis = kMiddleAxis;
    jump.angle_deg = [=](const BenchState& s) { return s.t_s >= jump_s ? kJump_deg : 0.0; };
    const ChannelTrace channel = TraceOf(bench.Measure(jump, 3));
    EXPECT_EQ(channel.effects.size(), 0u) << channel.summary << ", at " << jump_s;
    EXPECT_NE(channel.verdict, calibration::Verdict::kNone) << channel.summary;
    EXPECT_TRUE(std::ranges::any_of(channel.remarks, [](const std::string& remark) {
      return remark.find("a reading of the reference jumps") != std::string::npos;
    })) << channel.summary;
  }
}

}  // namespace
}  // namespace gyrobench::testing
