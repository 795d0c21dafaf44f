// An encoder without noise: its readings are rounded, and nothing else. What rounding leaves beats
// from reading to reading while the table turns evenly; it is no structure that an effect is
// behind.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <cstdint>
#include <string>

#include "tests/calibration/synthetic_bench.h"
#include "tests/calibration/trace_once.h"
#include "tests/calibration/trace_story.h"

namespace gyrobench::testing {
namespace {

using calibration::ChannelTrace;

constexpr double kStep_deg = 360.0 / 65536.0;

Motion ManyTurns() {
  Motion motion;
  motion.Rest(20.0);
  for (const double rate : {10.0, 20.0, 30.0, 45.0, 60.0})
    motion.ThereAndBack(kInnerAxis, 360.0, rate);
  return motion;
}

ChannelTrace TraceRounded(const Motion& motion, std::uint64_t seed, double slip_deg) {
  Story story;
  story.Follow(motion);
  story.UseTurningChannelAlone();
  story.seed = seed;
  story.gyro_hz = 200.0;
  story.reference_hz = 50.0;
  story.white_deg_s = 0.057;
  story.reading_deg = 0.0;
  story.spoil_angle = [slip_deg](AngleSample* reading) {
    const double slipped = reading->angle_deg + (reading->t_s > 61.0 ? slip_deg : 0.0);
    reading->angle_deg = kStep_deg * std::round(slipped / kStep_deg);
    return true;
  };
  return TraceOf(story.Collect());
}

TEST(ACoarseEncoder, LeavesNothingThatHasACause) {
  const Motion motion = ManyTurns();
  for (std::uint64_t seed = 1; seed <= 8; ++seed) {
    const ChannelTrace channel = TraceRounded(motion, seed, 0.0);
    EXPECT_EQ(channel.verdict, calibration::Verdict::kNone) << channel.summary << ", seed " << seed;
    EXPECT_THAT(channel.effects, ::testing::IsEmpty()) << channel.summary << ", seed " << seed;
    EXPECT_THAT(channel.remaining.findings, ::testing::IsEmpty()) << "seed " << seed;
  }
}

// Ten steps of the encoder are no rounding.
TEST(ACoarseEncoder, ThatSlipsBySomeOfItsStepsIsFound) {
  const Motion motion = ManyTurns();
  for (std::uint64_t seed = 1; seed <= 4; ++seed) {
    const ChannelTrace channel = TraceRounded(motion, seed, 10.0 * kStep_deg);
    ASSERT_EQ(channel.effects.size(), 1u) << channel.summary << ", seed " << seed;
    EXPECT_EQ(channel.effects[0].id, "angle.step");
    EXPECT_NEAR(std::fabs(channel.effects[0].parameters.at(0).value), 10.0 * kStep_deg, kStep_deg);
  }
}

}  // namespace
}  // namespace gyrobench::testing
