// An encoder without noise: its readings are rounded, and nothing else. What rounding leaves beats
// from reading to reading while the table turns evenly; it is no structure that an effect is
// behind.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <cstdint>
#include <functional>
#include <random>
#include <string>

#include "calibration/state/state_history.h"
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

// What the reference errs by before it is rounded [deg].
using ErrorOf = std::function<double(const AngleSample&)>;

ChannelTrace TraceRounded(const Motion& motion, std::uint64_t seed, const ErrorOf& error_deg,
                          double step_deg = kStep_deg, double reference_hz = 50.0) {
  Story story;
  story.Follow(motion);
  story.UseTurningChannelAlone();
  story.seed = seed;
  story.gyro_hz = 200.0;
  story.reference_hz = reference_hz;
  story.white_deg_s = 0.057;
  story.reading_deg = 0.0;
  story.spoil_angle = [&](AngleSample* reading) {
    const double read_deg = reading->angle_deg + error_deg(*reading);
    reading->angle_deg = step_deg * std::round(read_deg / step_deg);
    return true;
  };
  return TraceOf(story.Collect());
}

double NoError(const AngleSample&) { return 0.0; }

ErrorOf Slip(double slip_deg) {
  return [slip_deg](const AngleSample& reading) { return reading.t_s > 61.0 ? slip_deg : 0.0; };
}

ErrorOf Wave(double wave_deg, double periods) {
  return [=](const AngleSample& reading) {
    return wave_deg * std::sin(periods * reading.angle_deg * std::acos(-1.0) / 180.0);
  };
}

// All readings of a rest are the same count: their mean errs as one of them, and so do the readings
// next to it that are on the same count, and the next rest there. The table is six times where it
// began: all that is read there knows no more of that pose than one reading each time.
TEST(ACoarseEncoder, SaysNoMoreOfAPoseTheOftenerItIsRead) {
  Story story;
  story.Follow(ManyTurns());
  story.gyro_hz = 200.0;
  story.reference_hz = 50.0;
  story.reading_deg = 0.0;
  story.spoil_angle = [](AngleSample* reading) {
    reading->angle_deg = kStep_deg * std::round(reading->angle_deg / kStep_deg);
    return true;
  };
  const calibration::Recording recording = story.Collect();
  const calibration::StateHistory history =
      calibration::MakeStateHistory(recording, calibration::RoughSensitivity(recording), true, {});
  double information = 0.0, rests = 0.0;
  for (std::size_t k = 1; k + 1 < history.nodes.size(); ++k) {
    if (std::fabs(history.epochs[k].table_deg[kInnerAxis]) > 0.1 * kStep_deg) continue;
    const bool rested = history.still[k - 1], rests_on = history.still[k];
    if (rested && rests_on) continue;  // the same angle as before
    rests += rests_on ? 1.0 : 0.0;
    if (rested) continue;  // of a rest its begin stands for it
    information += 1.0 / history.ReferenceShare(k, {0.0, 0.0, 1.0});
  }
  EXPECT_GE(rests, 3.0);
  EXPECT_GT(information, 0.2);
  EXPECT_LT(information, 6.0);
}

TEST(ACoarseEncoder, LeavesNothingThatHasACause) {
  const Motion motion = ManyTurns();
  for (std::uint64_t seed = 1; seed <= 8; ++seed) {
    const ChannelTrace channel = TraceRounded(motion, seed, NoError);
    EXPECT_EQ(channel.verdict, calibration::Verdict::kNone) << channel.summary << ", seed " << seed;
    EXPECT_THAT(channel.effects, ::testing::IsEmpty()) << channel.summary << ", seed " << seed;
    EXPECT_THAT(channel.remaining.findings, ::testing::IsEmpty()) << "seed " << seed;
  }
}

// Ten steps of the encoder are no rounding.
TEST(ACoarseEncoder, ThatSlipsBySomeOfItsStepsIsFound) {
  const Motion motion = ManyTurns();
  for (std::uint64_t seed = 1; seed <= 4; ++seed) {
    const ChannelTrace channel = TraceRounded(motion, seed, Slip(10.0 * kStep_deg));
    ASSERT_EQ(channel.effects.size(), 1u) << channel.summary << ", seed " << seed;
    EXPECT_EQ(channel.effects[0].id, "angle.step");
    EXPECT_NEAR(std::fabs(channel.effects[0].parameters.at(0).value), 10.0 * kStep_deg, kStep_deg);
  }
}

// A wave of many steps is no rounding; left alone it would pass for a walk of the bias, beside
// which the rate of the reference is wrong by as much as the wave makes of it.
TEST(ACoarseEncoder, ShowsAWaveOfManySteps) {
  constexpr double kScale = 1.012, kWave_deg = 0.05;
  Motion slow;
  slow.Rest(20.0);
  for (const double rate : {5.0, 9.0, 15.0}) slow.ThereAndBack(kInnerAxis, 360.0, rate);
  std::uint64_t seed = 0;
  for (const double step_deg : {360.0 / 16384.0, kStep_deg, 360.0 / 1048576.0}) {
    // Of 150 periods the means of readings leave 0.93 at 5 deg/s and 0.48 at 15.
    for (const double periods : {36.0, 150.0}) {
      const ChannelTrace channel = TraceRounded(slow, ++seed, Wave(kWave_deg, periods), step_deg);
      ASSERT_THAT(channel.effects, ::testing::SizeIs(::testing::Ge(1u))) << channel.summary;
      EXPECT_EQ(channel.effects[0].id, "angle.ripple") << channel.summary;
      EXPECT_NEAR(channel.effects[0].parameters.at(0).value, kWave_deg, 0.05 * kWave_deg);
      const auto& scale = channel.baseline.parameters.at(0);
      EXPECT_NEAR(scale.value, kScale, 5.0 * scale.std_error) << scale.name;
      EXPECT_LT(scale.std_error, 2e-4);
    }
  }
}

// A quarter of a step is less than rounding errs by. At these speeds rounding beats with 16 periods
// a turn from node to node, and with 64 and more from reading to reading: 36 are none of these.
TEST(ACoarseEncoder, ShowsAWaveOfAQuarterOfAStep) {
  const Motion motion = ManyTurns();
  for (std::uint64_t seed = 1; seed <= 4; ++seed) {
    const ChannelTrace channel = TraceRounded(motion, seed, Wave(0.25 * kStep_deg, 36.0));
    ASSERT_THAT(channel.effects, ::testing::SizeIs(1)) << channel.summary << ", seed " << seed;
    EXPECT_EQ(channel.effects[0].id, "angle.ripple") << channel.summary;
    const auto& amplitude = channel.effects[0].parameters.at(0);
    EXPECT_NEAR(amplitude.value, 0.25 * kStep_deg, 4.0 * amplitude.std_error) << "seed " << seed;
    EXPECT_NEAR(channel.effects[0].parameters.at(2).value, 36.0, 0.5) << "seed " << seed;
  }
}

// A third of a step is less than rounding errs by. At these speeds rounding beats with 300, 104 and
// 174 periods a turn from reading to reading, and with 7, 38 and 40 from node to node: 54 are none
// of these.
TEST(ACoarseEncoder, ShowsAWaveOfLessThanHalfAStepWhereRoundingMakesNone) {
  constexpr double kFourteenBits_deg = 360.0 / 16384.0, kWave_deg = kFourteenBits_deg / 3.0;
  Motion motion;
  motion.Rest(20.0);
  for (const double rate : {12.31, 25.43, 33.7})
    for (int turn = 0; turn < 3; ++turn) motion.ThereAndBack(kInnerAxis, 360.0, rate);
  for (std::uint64_t seed = 1; seed <= 4; ++seed) {
    for (const double wave_deg : {0.0, kWave_deg}) {
      std::mt19937_64 random(seed);
      std::normal_distribution<double> noise(0.1 * kFourteenBits_deg, 0.15 * kFourteenBits_deg);
      const ChannelTrace channel = TraceRounded(
          motion, seed,
          [&](const AngleSample& reading) { return Wave(wave_deg, 54.0)(reading) + noise(random); },
          kFourteenBits_deg);
      ASSERT_THAT(channel.effects, ::testing::SizeIs(wave_deg > 0.0 ? 1u : 0u))
          << channel.summary << ", seed " << seed;
      if (wave_deg == 0.0) continue;
      EXPECT_EQ(channel.effects[0].id, "angle.ripple") << channel.summary;
      EXPECT_NEAR(channel.effects[0].parameters.at(0).value, kWave_deg, 0.1 * kWave_deg);
    }
  }
}

// At 18 deg/s each reading is 2.048 counts on from the one before, and rounding beats at 4.8 Hz. A
// wave of 896 periods a turn beats so as well from node to node, and the mean of a node's ten
// readings leaves a tenth of it: at the size of a count it would pass for the rounding.
TEST(ACoarseEncoder, ShowsNoWaveThatTheMeansOfReadingsLeaveOut) {
  constexpr double kCount_deg = 360.0 / 4096.0;
  Motion motion;
  motion.Rest(20.0);
  motion.ThereAndBack(kInnerAxis, 360.0, 18.0);
  for (std::uint64_t seed = 1; seed <= 4; ++seed) {
    std::mt19937_64 random(seed);
    std::normal_distribution<double> noise_deg(0.0, 0.14 * kCount_deg);
    const ChannelTrace channel = TraceRounded(
        motion, seed, [&](const AngleSample&) { return noise_deg(random); }, kCount_deg, 100.0);
    EXPECT_THAT(channel.effects, ::testing::IsEmpty()) << channel.summary << ", seed " << seed;
  }
}

// A table that goes to and fro between two places, of which one is rounded up and one down.
TEST(ACoarseEncoder, HasNoPlayOfAPartOfAStep) {
  Motion motion;
  motion.Rest(20.0);
  for (int turn = 0; turn < 30; ++turn)
    motion.ThereAndBack(kInnerAxis, 60.0 + 0.6 * kStep_deg, 20.0);
  for (std::uint64_t seed = 1; seed <= 4; ++seed) {
    const ChannelTrace channel = TraceRounded(motion, seed, NoError);
    EXPECT_THAT(channel.effects, ::testing::IsEmpty()) << channel.summary << ", seed " << seed;
  }
}

// Where a place lies near the edge of a step its readings flicker between two, by up to half a
// step, with next to no noise: that is no noise that would carry them over the steps, and each rest
// there misreads the place as the one before did.
TEST(ACoarseEncoder, ThatFlickersAtRestMisreadsAPlaceAlike) {
  constexpr double kFourteenBits_deg = 360.0 / 16384.0;
  Motion motion;
  motion.Rest(20.0);
  for (int turn = 0; turn < 8; ++turn) motion.ThereAndBack(kInnerAxis, 340.0, 39.0);
  for (const double beside : {0.08, 0.35, 0.42, 0.5}) {
    for (std::uint64_t seed = 1; seed <= 2; ++seed) {
      std::mt19937_64 random(seed);
      std::normal_distribution<double> noise(beside * kFourteenBits_deg, 0.15 * kFourteenBits_deg);
      const ChannelTrace channel = TraceRounded(
          motion, seed, [&](const AngleSample&) { return noise(random); }, kFourteenBits_deg);
      EXPECT_THAT(channel.effects, ::testing::IsEmpty())
          << channel.summary << ", " << beside << " of a step, seed " << seed;
      const auto& scale = channel.baseline.parameters.at(0);
      EXPECT_NEAR(scale.value, 1.012, 4.0 * scale.std_error) << beside << ", seed " << seed;
    }
  }
}

// One reading that is wrong is no step of the angle and another one back.
TEST(OneWrongReading, IsNoPairOfSteps) {
  const Motion motion = ManyTurns();
  for (const double wrong_deg : {0.02, 0.1, 0.6}) {
    for (std::uint64_t seed = 1; seed <= 3; ++seed) {
      const double at_s = 40.0 + 17.0 * static_cast<double>(seed);
      const ChannelTrace channel = TraceRounded(motion, seed, [=](const AngleSample& reading) {
        return std::fabs(reading.t_s - at_s) < 0.009 ? wrong_deg : 0.0;
      });
      EXPECT_LT(channel.effects.size(), 2u) << channel.summary << ", " << wrong_deg << " deg";
    }
  }
}

}  // namespace
}  // namespace gyrobench::testing
