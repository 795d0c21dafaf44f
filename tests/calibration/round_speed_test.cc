// A table that turns to and fro at a round speed, read at whole parts of a second: each turn meets
// the same places of the encoder, its steps beat with the readings, and a wave of many periods a
// turn is nearly the same in all of them. None of it is an effect.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <cstdint>
#include <numbers>
#include <random>

#include "tests/calibration/synthetic_bench.h"
#include "tests/calibration/trace_once.h"
#include "tests/calibration/trace_story.h"

namespace gyrobench::testing {
namespace {

using calibration::ChannelTrace;
using calibration::TraceResult;

constexpr double kFineSteps_deg = 360.0 / 16384.0, kCoarseSteps_deg = 360.0 / 4096.0;
constexpr double kSpeed_deg_s = 20.0;

Story Turns(double reading_deg, double step_deg, double reference_hz, std::uint64_t seed) {
  Motion motion;
  motion.Rest(20.0);
  for (int turn = 0; turn < 10; ++turn) motion.ThereAndBack(kInnerAxis, 360.0, kSpeed_deg_s);
  Story story;
  story.Follow(motion);
  story.seed = seed;
  story.gyro_hz = 100.0;
  story.reference_hz = reference_hz;
  story.white_deg_s = 0.05;
  story.reading_deg = reading_deg;
  story.temperature_degC = [](double) { return 25.0; };
  story.drift_deg_s_per_degC = 0.0;
  if (step_deg > 0.0) {
    story.spoil_angle = [=](AngleSample* reading) {
      reading->angle_deg = step_deg * std::round(reading->angle_deg / step_deg);
      return true;
    };
  }
  return story;
}

// `most_error`: of the scale factor, as stated.
void ExpectNothing(const ChannelTrace& channel, double most_error, std::uint64_t seed) {
  EXPECT_EQ(channel.verdict, calibration::Verdict::kNone) << channel.summary << ", seed " << seed;
  EXPECT_THAT(channel.effects, ::testing::IsEmpty()) << channel.summary << ", seed " << seed;
  EXPECT_THAT(channel.remaining.findings, ::testing::IsEmpty()) << "seed " << seed;
  const auto& scale = channel.baseline.parameters.at(0);
  EXPECT_NEAR(scale.value, 1.012, 4.5 * scale.std_error) << "seed " << seed;
  EXPECT_LT(scale.std_error, most_error) << "seed " << seed;
}

// From reading to reading there are 91.02 steps: at an even speed their error is hardly another
// from one to the next, and in the ramps it is any.
TEST(ARoundSpeed, MeetsTheStepsOfAnEncoderAlikeInEachTurn) {
  for (std::uint64_t seed = 1; seed <= 6; ++seed) {
    Story story = Turns(5e-4, kFineSteps_deg, 10.0, seed);
    story.UseTurningChannelAlone();
    ExpectNothing(TraceOf(story.Collect()), 5e-5, seed);
  }
}

// Of 180 or 360 periods a turn all readings at an even speed meet the same part, and what a fit to
// such a wave finds of it there is the noise of the readings.
TEST(ARoundSpeed, MeetsAWaveOfManyPeriodsAtTheSamePlaces) {
  for (const double reference_hz : {10.0, 20.0}) {
    for (std::uint64_t seed = 1; seed <= 4; ++seed) {
      Story story = Turns(1e-3, 0.0, reference_hz, seed);
      story.UseTurningChannelAlone();
      ExpectNothing(TraceOf(story.Collect()), 5e-5, seed);
    }
  }
}

// A wave that is another at each reading, and one that the readings take for three periods a turn.
TEST(ARoundSpeed, ShowsAWaveThatReadingsMeetInOtherParts) {
  constexpr double kWave_deg = 0.02;
  struct Wave {
    double periods, reference_hz;
  };
  for (const auto& [periods, reference_hz] : {Wave{90.0, 20.0}, Wave{183.0, 10.0}}) {
    for (std::uint64_t seed = 1; seed <= 3; ++seed) {
      Story story = Turns(1e-3, 0.0, reference_hz, seed);
      story.UseTurningChannelAlone();
      story.spoil_angle = [periods = periods](AngleSample* reading) {
        reading->angle_deg +=
            kWave_deg * std::sin(periods * reading->angle_deg * std::numbers::pi / 180.0);
        return true;
      };
      const ChannelTrace channel = TraceOf(story.Collect());
      ASSERT_THAT(channel.effects, ::testing::SizeIs(1)) << channel.summary << ", seed " << seed;
      EXPECT_EQ(channel.effects[0].id, "angle.ripple");
      EXPECT_NEAR(channel.effects[0].parameters.at(0).value, kWave_deg, 0.1 * kWave_deg);
    }
  }
}

// A scale factor that differs by the sense of the turn makes more than any rounding.
TEST(ARoundSpeed, LeavesWhatIsMoreThanTheStepsOfAnEncoder) {
  for (std::uint64_t seed = 1; seed <= 2; ++seed) {
    Story story = Turns(5e-4, kFineSteps_deg, 10.0, seed);
    story.UseTurningChannelAlone();
    const auto rate_deg_s = story.rate_deg_s;
    story.spoil_gyro = [=](GyroSample* sample) {
      sample->xi[2] += 131.0 * 0.004 * std::fabs(rate_deg_s(sample->t_s));
      return true;
    };
    const ChannelTrace channel = TraceOf(story.Collect());
    EXPECT_THAT(channel.effects, ::testing::Not(::testing::IsEmpty())) << channel.summary;
  }
}

// A channel that feels two hundredths of the turns feels so much of their rounding, which at 11.38
// steps from reading to reading is a tone of 7.6 Hz, and others by its harmonics.
TEST(ARoundSpeed, MakesNoToneInAChannelThatHardlyTurns) {
  for (std::uint64_t seed = 1; seed <= 3; ++seed) {
    Story story = Turns(5e-4, kCoarseSteps_deg, 20.0, seed);
    story.scale = {0.02, -0.02, 1.012};
    story.white_deg_s = 0.01;
    const TraceResult result = TraceAll(story.Collect());
    for (const ChannelTrace& channel : result.channels)
      EXPECT_THAT(channel.effects, ::testing::IsEmpty()) << channel.summary << ", seed " << seed;
  }
}

// Such a channel has a tone of its own where that is larger than what rounding makes, or of another
// frequency.
TEST(ARoundSpeed, LeavesATone) {
  struct Tone {
    double frequency_hz, amplitude_deg_s;
  };
  for (const auto& [frequency_hz, amplitude_deg_s] : {Tone{7.556, 0.15}, Tone{6.1, 0.02}}) {
    Story story = Turns(5e-4, kCoarseSteps_deg, 20.0, 1);
    story.scale = {0.02, -0.02, 1.012};
    story.white_deg_s = 0.01;
    story.spoil_gyro = [=](GyroSample* sample) {
      const double turns = frequency_hz * sample->t_s;
      sample->xi[0] += 131.0 * amplitude_deg_s * std::sin(2.0 * std::numbers::pi * turns);
      return true;
    };
    const ChannelTrace channel = TraceOf(story.Collect());
    ASSERT_THAT(channel.effects, ::testing::SizeIs(1)) << channel.summary << ", " << frequency_hz;
    EXPECT_EQ(channel.effects[0].id, "bias.tone");
    EXPECT_NEAR(channel.effects[0].parameters.at(0).value, amplitude_deg_s, 0.2 * amplitude_deg_s);
  }
}

}  // namespace
}  // namespace gyrobench::testing
