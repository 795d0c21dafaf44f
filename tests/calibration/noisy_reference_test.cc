// What a reference shows whose readings are few and noisy beside the gyro: steps of the angle, the
// ends of rests, and how exactly an angle is known.
#include <gtest/gtest.h>

#include <cmath>
#include <cstdint>
#include <numbers>
#include <random>
#include <string>

#include "calibration/gls/whitener.h"
#include "calibration/state/state_history.h"
#include "calibration/trace/problem.h"
#include "calibration/trace/scans.h"
#include "tests/calibration/injected.h"
#include "tests/calibration/synthetic_bench.h"
#include "tests/calibration/trace_once.h"
#include "tests/calibration/trace_story.h"

namespace gyrobench::testing {
namespace {

using calibration::ChannelTrace;
using calibration::Recording;
using calibration::StateHistory;

constexpr double kReading_deg = 0.045;

// Turns and back at four speeds, with a second of rest between.
Motion ManyTurns(int rounds) {
  Motion motion;
  motion.Rest(10.0);
  for (int round = 0; round < rounds; ++round) {
    for (const double rate : {6.0, 10.0, 20.0, 40.0}) motion.ThereAndBack(kInnerAxis, 180.0, rate);
  }
  return motion;
}

Story StoryOf(std::uint64_t seed) {
  Story story;
  story.seed = seed;
  story.reference_hz = 10.0;
  story.reading_deg = kReading_deg;
  story.UseTurningChannelAlone();
  story.info.temperature_present = false;
  story.temperature_degC = [](double) { return 25.0; };
  return story;
}

Story StoryOf(const Motion& motion, std::uint64_t seed) {
  Story story = StoryOf(seed);
  story.Follow(motion);
  return story;
}

// A history refers to its recording.
StateHistory TrailOf(const Recording& recording) {
  return MakeStateHistory(recording, {kMissing, kMissing, 131.0}, true, {});
}

void ExpectTheStepAlone(const ChannelTrace& channel, double size_deg, std::uint64_t seed) {
  ASSERT_EQ(channel.effects.size(), 1u) << channel.summary << ", seed " << seed;
  EXPECT_EQ(channel.effects[0].id, "angle.step") << "seed " << seed;
  for (const calibration::ModelParameter& parameter : channel.effects[0].parameters) {
    if (parameter.name == "b_inner") {
      EXPECT_NEAR(std::fabs(parameter.value), size_deg, 5.0 * parameter.std_error);
    }
  }
}

// The tails beside which a step of the angle is judged, for white residuals that are drawn.
class DrawnTails {
 public:
  DrawnTails(const Motion& motion, double reading_deg)
      : story_(Told(motion, reading_deg)),
        recording_(story_.Collect()),
        history_(TrailOf(recording_)),
        problem_({&history_, 1}, 2, 131.0),
        whitener_(problem_.intervals(),
                  {story_.white_deg_s / std::sqrt(story_.gyro_hz), 1e-5, reading_deg}),
        model_(problem_.MakeBaseline().columns) {
    whitener_.Apply(model_);
  }

  // How often they are wider than normal ones. `wide_share`: of values that are five times as wide.
  int Wide(int draws, double wide_share) const {
    int wide = 0;
    for (int seed = 1; seed <= draws; ++seed) wide += AreWide(Draw(seed, wide_share));
    return wide;
  }

 private:
  static Story Told(const Motion& motion, double reading_deg) {
    Story story = StoryOf(motion, 1);
    story.reading_deg = reading_deg;
    return story;
  }
  Eigen::VectorXd Draw(int seed, double wide_share) const {
    std::mt19937_64 random(static_cast<std::uint64_t>(seed));
    std::normal_distribution<double> normal;
    std::uniform_real_distribution<double> share;
    Eigen::VectorXd residual(problem_.rows());
    for (double& value : residual)
      value = normal(random) * (share(random) < wide_share ? 5.0 : 1.0);
    return residual;
  }
  bool AreWide(const Eigen::VectorXd& residual) const {
    const calibration::WithinNodes no_readings;
    for (const calibration::ScanPeak& peak :
         Scan(problem_, whitener_, model_, residual, {no_readings, {}})) {
      if (peak.effect->id == "angle.step") return std::isfinite(peak.tail_freedom);
    }
    ADD_FAILURE() << "no step of the angle was looked for";
    return false;
  }

  Story story_;
  Recording recording_;
  StateHistory history_;
  calibration::ChannelProblem problem_;
  calibration::Whitener whitener_;
  Eigen::MatrixXd model_;
};

// A step here and one in the next row are nearly the same for noisy readings: what lies beyond
// three standard deviations comes in crowds by chance. Counted row by row, it would pass for tails
// beside which no step can be told.
TEST(TailsOfNoisyReadings, AreNormalWhereTheNoiseIs) {
  const Motion motion = ManyTurns(4);
  EXPECT_LE(DrawnTails(motion, kReading_deg).Wide(600, 0.0), 2);
  EXPECT_LE(DrawnTails(motion, 0.002).Wide(30, 0.0), 1);
}

TEST(TailsOfReadings, AreWideWhereSomeReadingsAre) {
  EXPECT_GE(DrawnTails(ManyTurns(4), 0.002).Wide(30, 0.03), 28);
}

// It was taken for two or more steps of the bias.
TEST(AStepOfTheAngleBesideNoisyReadings, IsNamedAlone) {
  constexpr double kStep_deg = 1.2;
  const Motion motion = ManyTurns(4);
  const double step_s = 0.55 * motion.duration_s();
  for (std::uint64_t seed = 1; seed <= 3; ++seed) {
    Story story = StoryOf(motion, seed);
    story.spoil_angle = [&](AngleSample* sample) {
      if (sample->t_s > step_s) sample->angle_deg += kStep_deg;
      return true;
    };
    ExpectTheStepAlone(TraceOf(story.Collect()), kStep_deg, seed);
  }
}

// Where the bias walks the white rows after a step have a little of it each. On a part of the data
// that is held out its size is what the rows say in which it is, not what all the others do.
TEST(AStepOfTheAngleBesideAWalkingBias, IsNamedAlone) {
  constexpr double kStep_deg = 0.03, kWalk_deg_s_sqrt_s = 3e-4;
  const Motion motion = ManyTurns(3);
  const double step_s = 0.55 * motion.duration_s();
  for (std::uint64_t seed = 1; seed <= 6; ++seed) {
    Story story = StoryOf(motion, seed);
    story.reference_hz = 50.0;
    story.reading_deg = 0.002;
    std::mt19937_64 random(seed);
    std::normal_distribution<double> step;
    double bias_deg_s = 0.0;
    story.spoil_gyro = [&](GyroSample* sample) {
      bias_deg_s += kWalk_deg_s_sqrt_s / std::sqrt(story.gyro_hz) * step(random);
      sample->xi[2] += 131.0 * bias_deg_s;
      return true;
    };
    story.spoil_angle = [&](AngleSample* sample) {
      if (sample->t_s > step_s) sample->angle_deg += kStep_deg;
      return true;
    };
    ExpectTheStepAlone(TraceOf(story.Collect()), kStep_deg, seed);
  }
}

// Rests of 4 s, a little motion of half a second, and at once a large one of two.
struct LittleAndLarge {
  static constexpr double kRest_s = 4.03, kLittle_s = 0.5, kLarge_s = 2.0;
  static constexpr double kRound_s = kRest_s + kLittle_s + kLarge_s;
  // A raised cosine.
  struct Wave {
    double since_s = 0.0, half_deg = 0.0, hz = 1.0;
  };
  static Wave At(double t_s) {
    const double moving_s = std::fmod(t_s, kRound_s) - kRest_s;
    if (moving_s < 0.0) return {};
    if (moving_s < kLittle_s) return {moving_s, 0.215, 1.0 / kLittle_s};
    return {moving_s - kLittle_s, 1.5, 1.0};
  }
  static double Angle(double t_s) {
    const Wave wave = At(t_s);
    return wave.half_deg * (1.0 - std::cos(2.0 * std::numbers::pi * wave.hz * wave.since_s));
  }
  static double Rate(double t_s) {
    const Wave wave = At(t_s);
    const double w = 2.0 * std::numbers::pi * wave.hz;
    return wave.half_deg * w * std::sin(w * wave.since_s);
  }
};

// A reading that is out, and back within the noise, is no motion yet: the rest seems to go on. The
// gyro, though it has a tone, shows that it does not. The same backward.
TEST(ARestBesideNoisyReadings, HasNoTurningInIt) {
  constexpr double kDuration_s = 60.0 * LittleAndLarge::kRound_s;
  for (const bool backward : {false, true}) {
    for (std::uint64_t seed = 1; seed <= 6; ++seed) {
      Story story = StoryOf(seed);
      story.duration_s = kDuration_s;
      story.angle_deg = [&](double t_s) {
        return LittleAndLarge::Angle(backward ? kDuration_s - t_s : t_s);
      };
      story.rate_deg_s = [&](double t_s) {
        return backward ? -LittleAndLarge::Rate(kDuration_s - t_s) : LittleAndLarge::Rate(t_s);
      };
      story.gyro_hz = 100.0;
      story.reference_hz = 5.0;
      story.spoil_gyro = [](GyroSample* sample) {
        sample->xi[2] += 131.0 * 0.13 * std::sin(2.0 * std::numbers::pi * 2.2 * sample->t_s);
        return true;
      };
      const Recording recording = story.Collect();
      const StateHistory history = TrailOf(recording);
      double rested_s = 0.0;
      for (std::size_t i = 0; i < history.still.size(); ++i) {
        if (!history.still[i]) continue;
        const double from_s = history.nodes[i].t_s, to_s = history.nodes[i + 1].t_s;
        rested_s += to_s - from_s;
        EXPECT_NEAR(story.angle_deg(from_s), story.angle_deg(to_s), 0.03)
            << "from " << from_s << " s to " << to_s << " s, seed " << seed
            << (backward ? ", backward" : "");
      }
      EXPECT_GT(rested_s, 100.0);
    }
  }
}

// Rests so short that much of what looks like one is the end of a motion.
TEST(AnAxisWithShortRests, IsReadAsExactlyAsItsReadingsAre) {
  Motion motion;
  for (int round = 0; round < 12; ++round) motion.ThereAndBack(kInnerAxis, 20.0, 8.0).Rest(0.5);
  for (std::uint64_t seed = 1; seed <= 6; ++seed) {
    const Recording recording = StoryOf(motion, seed).Collect();
    const StateHistory history = TrailOf(recording);
    // Of some hundred changes the median is known to a tenth.
    EXPECT_NEAR(history.axis_error_deg[2], kReading_deg, 0.4 * kReading_deg) << "seed " << seed;
    EXPECT_LE(history.axis_error_deg[2], history.angle_error_deg);
  }
}

// A slip of the reference by thirty times its noise and more, while nothing turns.
TEST(AClearStepOfTheAngle, IsNamedAlone) {
  const Motion motion = EveryMotion();
  for (std::uint64_t seed = 1; seed <= 6; ++seed) {
    for (const double size_deg : {0.1, 0.5}) {
      Injection slip;
      slip.angle_deg = [=](const BenchState& s) { return s.t_s > 40.0 ? size_deg : 0.0; };
      ExpectTheStepAlone(TraceOf(SyntheticBench(motion).Measure(slip, seed)), size_deg, seed);
    }
  }
}

// A wave of which a period is twelve times the reading's error: read as a slower one between the
// readings, it would be several others.
TEST(ARippleOfManyPeriods, IsNamedBesideNoisyReadings) {
  constexpr double kRipple_deg = 0.1;
  const Motion motion = ManyTurns(6);
  for (const int periods : {60, 180}) {
    for (std::uint64_t seed = 1; seed <= 2; ++seed) {
      Story story = StoryOf(motion, seed);
      story.spoil_angle = [=](AngleSample* reading) {
        const double turned_rad = story.angle_deg(reading->t_s) * std::numbers::pi / 180.0;
        reading->angle_deg -= kRipple_deg * std::sin(periods * turned_rad);
        return true;
      };
      const ChannelTrace channel = TraceOf(story.Collect());
      ASSERT_EQ(channel.effects.size(), 1u) << channel.summary << ", " << periods;
      EXPECT_EQ(channel.effects[0].id, "angle.ripple") << channel.summary;
      for (const calibration::ModelParameter& parameter : channel.effects[0].parameters) {
        const bool wave = parameter.name == "amplitude_inner";
        if (!wave && parameter.name != "k") continue;
        const double within = wave ? 4.0 * parameter.std_error + 0.04 * kRipple_deg : 0.5;
        EXPECT_NEAR(parameter.value, wave ? kRipple_deg : periods, within) << parameter.name;
      }
    }
  }
}

// The error of a reading is in the output and in the angle that a wave is a function of.
TEST(NoRipple, IsMadeOfTheErrorsOfReadings) {
  const Motion motion = ManyTurns(6);
  for (std::uint64_t seed = 1; seed <= 6; ++seed) {
    const ChannelTrace channel = TraceOf(StoryOf(motion, seed).Collect());
    EXPECT_TRUE(channel.effects.empty()) << channel.summary << ", seed " << seed;
  }
}

// A turn at one speed, the offset and what grows with the acceleration of its ramps are nearly one:
// the noise of readings in the ramps' rates, which the output has as well, would tell them apart.
TEST(AnAxisThatTurnsOneWayAtOneSpeed, HasItsScaleFactorAndNothingElse) {
  Motion motion;
  motion.Rest(20.0);
  for (int turn = 0; turn < 60; ++turn) motion.Turn(kInnerAxis, 90.0, 30.0).Rest(3.0);
  double square = 0.0;
  int named = 0;
  constexpr int kSeeds = 6;
  for (std::uint64_t seed = 1; seed <= kSeeds; ++seed) {
    Story story = StoryOf(motion, seed);
    story.gyro_hz = 100.0;
    story.white_deg_s = 0.05;
    story.reference_hz = 20.0;
    story.reading_deg = 0.05;
    const ChannelTrace channel = TraceOf(story.Collect());
    named += channel.effects.empty() ? 0 : 1;
    const auto& scale = channel.baseline.parameters[0];
    ASSERT_EQ(scale.name, "scale_factor");
    square += std::pow((scale.value - story.scale[2]) / scale.std_error, 2);
  }
  // At a false discovery of 1 % two of six are named once in 700; a chi square of six degrees is as
  // large once in 25,000.
  EXPECT_LE(named, 1);
  EXPECT_LT(square, 30.0);
}

// So slowly that a node hardly moves by what it scatters: no rest, no step, no wave, and the scale
// factor that is there.
TEST(ATableThatTurnsSlowerThanItsReadingsTell, HasItsScaleFactorAndNothingElse) {
  const double scale = BenchSensor().m_row[2];
  for (const double reading_deg : {0.01, 0.02}) {
    const Motion motion = Motion()
                              .Rest(20)
                              .ThereAndBack(kInnerAxis, 30, 0.25)
                              .ThereAndBack(kInnerAxis, 40, 0.5)
                              .ThereAndBack(kInnerAxis, 40, 1.0)
                              .Rest(10);
    BenchSensor sensor;
    sensor.reading_deg = reading_deg;
    for (std::uint64_t seed = 1; seed <= 4; ++seed) {
      const ChannelTrace channel = TraceOf(SyntheticBench(motion, sensor).Measure({}, seed));
      EXPECT_TRUE(channel.effects.empty()) << channel.summary;
      EXPECT_NEAR(channel.baseline.whitened_rms, 1.0, 0.05) << channel.summary;
      ExpectWithinItsInterval(channel.baseline.parameters, {"scale_factor", scale});
      EXPECT_LT(channel.baseline.parameters[0].std_error, 2e-3 * scale);
    }
  }
}

}  // namespace
}  // namespace gyrobench::testing
