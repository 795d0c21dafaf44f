// What single readings of a moving node say beyond their mean.
#include "calibration/trace/within_nodes.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdint>
#include <numbers>
#include <string>

#include "calibration/gls/independent_columns.h"
#include "calibration/state/state_history.h"
#include "tests/calibration/synthetic_bench.h"
#include "tests/calibration/trace_once.h"
#include "tests/calibration/trace_story.h"

namespace gyrobench::testing {
namespace {

using calibration::Baseline;
using calibration::ChannelProblem;
using calibration::ChannelTrace;
using calibration::ModelParameter;
using calibration::Recording;
using calibration::StateHistory;
using calibration::TracedEffect;
using calibration::WithinNodes;

constexpr double kOneReading_deg = 0.005, kReadings_hz = 100.0;

Motion FineTurns() {
  Motion motion;
  motion.Rest(10.0);
  for (int round = 0; round < 3; ++round) {
    for (const double rate : {15.0, 25.0, 45.0}) motion.ThereAndBack(kInnerAxis, 360.0, rate);
  }
  return motion;
}

Story FineStory(std::uint64_t seed) {
  Story story;
  story.Follow(FineTurns());
  story.seed = seed;
  story.gyro_hz = story.reference_hz = kReadings_hz;
  story.white_deg_s = 0.02;
  story.reading_deg = kOneReading_deg;
  story.UseTurningChannelAlone();
  story.info.temperature_present = false;
  story.temperature_degC = [](double) { return 25.0; };
  return story;
}

const ModelParameter* ParameterOf(const TracedEffect& effect, const std::string& name) {
  for (const ModelParameter& parameter : effect.parameters) {
    if (parameter.name == name) return &parameter;
  }
  return nullptr;
}

// The bound of a wave's amplitude by n readings with independent errors s is s sqrt(2 / n). At 45
// deg/s a node turns by more than a period, and its mean knows next to nothing of the wave.
TEST(AWaveOfManyPeriods, IsKnownAsWellAsAllReadingsAllow) {
  constexpr int kPeriods = 90, kSeeds = 8;
  constexpr double kWave_deg = 0.0009, kRate_deg_s = 0.05;
  double square = 0.0;
  for (std::uint64_t seed = 1; seed <= kSeeds; ++seed) {
    Story story = FineStory(seed);
    double moving = 0.0;
    story.spoil_angle = [&](AngleSample* reading) {
      if (std::fabs(story.rate_deg_s(reading->t_s)) > kRate_deg_s) moving += 1.0;
      const double turned_rad = story.angle_deg(reading->t_s) * std::numbers::pi / 180.0;
      reading->angle_deg -= kWave_deg * std::sin(kPeriods * turned_rad);
      return true;
    };
    const ChannelTrace channel = TraceOf(story.Collect());
    ASSERT_EQ(channel.effects.size(), 1u) << channel.summary << ", seed " << seed;
    EXPECT_EQ(channel.effects[0].id, "angle.ripple") << channel.summary;
    const ModelParameter* wave = ParameterOf(channel.effects[0], "amplitude_inner");
    ASSERT_NE(wave, nullptr);
    const double bound_deg = kOneReading_deg * std::sqrt(2.0 / moving);
    EXPECT_LT(wave->std_error, 1.15 * bound_deg) << "seed " << seed;
    EXPECT_GT(wave->std_error, 0.95 * bound_deg) << "seed " << seed;
    square += std::pow((wave->value - kWave_deg) / bound_deg, 2) / kSeeds;
  }
  EXPECT_LT(square, 2.5);  // chi square of eight: beyond it once in a hundred
}

TEST(AWaveOfManyPeriods, IsNotMadeOfTheErrorsOfReadings) {
  for (std::uint64_t seed = 11; seed <= 20; ++seed) {
    const ChannelTrace channel = TraceOf(FineStory(seed).Collect());
    EXPECT_TRUE(channel.effects.empty()) << channel.summary << ", seed " << seed;
  }
}

// At 36 deg/s each node begins where a wave of a hundred periods a turn begins anew: what goes
// evenly within every node would be one.
TEST(AWaveOfManyPeriods, IsNotMadeOfWhatGoesEvenlyWithinNodes) {
  constexpr double kEccentric_deg = 0.05;
  Motion motion;
  motion.Rest(10.0);
  for (int round = 0; round < 4; ++round) motion.Turn(kInnerAxis, 720.0, 36.0);
  for (std::uint64_t seed = 21; seed <= 24; ++seed) {
    Story story = FineStory(seed);
    story.Follow(motion);
    story.spoil_angle = [&](AngleSample* reading) {
      const double turned_rad = story.angle_deg(reading->t_s) * std::numbers::pi / 180.0;
      reading->angle_deg -= kEccentric_deg * std::sin(turned_rad);
      return true;
    };
    const ChannelTrace channel = TraceOf(story.Collect());
    ASSERT_EQ(channel.effects.size(), 1u) << channel.summary << ", seed " << seed;
    EXPECT_EQ(channel.effects[0].id, "angle.eccentricity_1") << channel.summary;
  }
}

// Six errors of a reading, between two readings in the middle of a node or at its edge.
TEST(AStepOfTheAngle, IsPlacedBetweenTheReadingsThatItIsBetween) {
  for (const double at_s : {20.02, 20.055, 20.09}) {
    constexpr double kStep_deg = 0.03;
    Story story = FineStory(31);
    story.spoil_angle = [=](AngleSample* reading) {
      if (reading->t_s > at_s) reading->angle_deg += kStep_deg;
      return true;
    };
    ASSERT_GT(std::fabs(story.rate_deg_s(at_s)), 1.0);
    const ChannelTrace channel = TraceOf(story.Collect());
    ASSERT_EQ(channel.effects.size(), 1u) << channel.summary << ", " << at_s;
    EXPECT_EQ(channel.effects[0].id, "angle.step") << channel.summary;
    const ModelParameter *size = ParameterOf(channel.effects[0], "b_inner"),
                         *time = ParameterOf(channel.effects[0], "t0");
    ASSERT_TRUE(size != nullptr && time != nullptr);
    EXPECT_NEAR(std::fabs(size->value), kStep_deg, 4.0 * size->std_error);
    EXPECT_NEAR(time->value, at_s, 0.015);
  }
}

// Rows of one channel of a measurement, beside the least squares of its baseline.
struct Rows {
  explicit Rows(const Recording& recording, double walk_deg_sqrt_s)
      : history(MakeStateHistory(recording, {kMissing, kMissing, 131.0}, true, {})),
        problem(std::span(&history, 1), 2, 131.0),
        baseline(problem.MakeBaseline()),
        within(problem, baseline,
               calibration::SolveIndependent(baseline.columns.transpose() * baseline.columns,
                                             baseline.columns.transpose() * problem.output_deg()),
               walk_deg_sqrt_s) {}
  StateHistory history;
  ChannelProblem problem;
  Baseline baseline;
  WithinNodes within;
};

TEST(RowsOfSingleReadings, AreWhite) {
  for (const double white_deg_s : {0.005, 0.04}) {
    Story story = FineStory(41);
    story.white_deg_s = white_deg_s;
    const Recording recording = story.Collect();
    const Rows rows(recording, white_deg_s / std::sqrt(kReadings_hz));
    const Eigen::VectorXd& output = rows.within.output();
    ASSERT_GT(output.size(), 5000);
    // Ten readings a node, of which one is the mean.
    EXPECT_NEAR(output.squaredNorm() / (0.9 * static_cast<double>(output.size())), 1.0, 0.05)
        << white_deg_s;
  }
}

// A tone of the gyro, in counts.
Story WithTone(Story story, double deg_s, double hz) {
  story.spoil_gyro = [=](GyroSample* sample) {
    sample->xi[2] += 131.0 * deg_s * std::sin(2.0 * std::numbers::pi * hz * sample->t_s);
    return true;
  };
  return story;
}

// Whatever its frequency, also one of which most goes evenly within a node: what the columns leave
// of it is white.
TEST(RowsOfSingleReadings, AreWhiteBesideATone) {
  for (const double hz : {0.15, 0.7, 2.0, 4.0}) {
    const Recording recording = WithTone(FineStory(44), 1.0, hz).Collect();
    const Rows rows(recording, 0.02 / std::sqrt(kReadings_hz));
    const Eigen::VectorXd& output = rows.within.output();
    ASSERT_GT(output.size(), 5000);
    calibration::BasisContext context;
    context.nonlinear = {hz};
    const Eigen::MatrixXd tone =
        rows.within.Columns(*calibration::FindEffect("bias.tone"), context, {});
    const Eigen::VectorXd left =
        output -
        tone * calibration::SolveIndependent(tone.transpose() * tone, tone.transpose() * output);
    const double white = 0.9 * static_cast<double>(output.size());
    EXPECT_NEAR(left.squaredNorm() / white, 1.0, 0.05) << hz << " Hz";
    if (hz > 1.0) {
      EXPECT_GT(output.squaredNorm(), 1.5 * white) << hz << " Hz";
    }
  }
}

// At 5 deg/s a wave of 144 periods a turn is a tone of 2 Hz.
TEST(ATone, IsNotTakenForAWaveOfTheAngleAsWell) {
  Motion motion;
  motion.Rest(20.0);
  for (int round = 0; round < 2; ++round) {
    for (const double rate : {5.0, 10.0}) motion.ThereAndBack(kInnerAxis, 180.0, rate);
  }
  for (std::uint64_t seed = 51; seed <= 56; ++seed) {
    Story story = FineStory(seed);
    story.Follow(motion);
    const ChannelTrace channel = TraceOf(WithTone(story, 0.3, 2.0).Collect());
    ASSERT_EQ(channel.effects.size(), 1u) << channel.summary << ", seed " << seed;
    EXPECT_EQ(channel.effects[0].id, "bias.tone") << channel.summary;
  }
}

TEST(RowsOfSingleReadings, AreNoneOfCoarseEncodersNorBesideANoisyGyro) {
  Story coarse = FineStory(42);
  coarse.spoil_angle = [](AngleSample* reading) {
    constexpr double kStep_deg = 360.0 / 4096.0;
    reading->angle_deg = kStep_deg * std::round(reading->angle_deg / kStep_deg);
    return true;
  };
  const Recording of_coarse = coarse.Collect();
  EXPECT_TRUE(Rows(of_coarse, 0.002).within.empty());
  Story noisy = FineStory(43);
  noisy.white_deg_s = 0.3;
  const Recording of_noisy = noisy.Collect();
  EXPECT_TRUE(Rows(of_noisy, 0.03).within.empty());
}

}  // namespace
}  // namespace gyrobench::testing
