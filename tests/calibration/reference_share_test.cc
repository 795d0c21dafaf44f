// How much of the reference's error each channel feels.
#include <gtest/gtest.h>

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <random>
#include <span>
#include <vector>

#include "calibration/gls/noise_search.h"
#include "calibration/gls/statistics.h"
#include "calibration/signal/collector.h"
#include "calibration/state/rounding_wave.h"
#include "calibration/state/state_history.h"
#include "calibration/trace/problem.h"
#include "tests/calibration/synthetic_bench.h"

namespace gyrobench::testing {
namespace {

using calibration::ChannelProblem;
using calibration::MakeStateHistory;
using calibration::Recording;
using calibration::RoughSensitivity;
using calibration::StateHistory;

constexpr std::size_t kChannel = 2;

struct Told {
  Recording recording;
  std::vector<StateHistory> histories;
};

Told Tell(const Motion& motion, const BenchSensor& sensor, std::uint64_t seed) {
  Told told{SyntheticBench(motion, sensor).Measure({}, seed), {}};
  told.histories.push_back(
      MakeStateHistory(told.recording, RoughSensitivity(told.recording), true, {}));
  told.histories.front().recording = &told.recording;
  return told;
}

// Of the channel z at the ends of intervals in which the axis turns fast.
std::vector<double> SharesWhileTurning(const Told& told, TableAxis axis) {
  const StateHistory& history = told.histories.front();
  std::vector<double> shares;
  for (std::size_t i = 0; i < history.still.size(); ++i) {
    if (std::fabs(history.midpoints[2 * i].table_rate_deg_s[axis]) > 10.0)
      shares.push_back(history.ReferenceShare(i + 1, {0.0, 0.0, 1.0}));
  }
  return shares;
}

// The bench reads its reference evenly: a node is the mean of all readings since the one before.
TEST(ReferenceShare, IsOneOverTheReadingsOfANodeWhereTheChannelTurns) {
  const Told told = Tell(Motion().Rest(20).ThereAndBack(kInnerAxis, 180, 20).Rest(20), {}, 1);
  const std::vector<double> shares = SharesWhileTurning(told, kInnerAxis);
  ASSERT_GT(shares.size(), 100U);
  const double readings = static_cast<double>(told.recording.reference_samples) /
                          static_cast<double>(told.histories.front().nodes.size()) / 3.0;
  ASSERT_GT(readings, 2.0);
  for (const double share : shares) EXPECT_NEAR(share, 1.0 / readings, 0.05 / readings);
}

// A node has one reading of such an axis, or the one of the node before: no mean, but it rests.
TEST(AnAxisThatRests, StaysWhereItIsHoweverSeldomItIsRead) {
  BenchSensor sensor;
  sensor.reads_resting_axes = 10;
  for (std::uint64_t seed = 1; seed <= 5; ++seed) {
    const Motion motion = Motion().Rest(20).ThereAndBack(kInnerAxis, 300, 5).Rest(20);
    const Told told = Tell(motion, sensor, seed);
    const StateHistory& history = told.histories.front();
    int turns = 0, moved = 0;
    for (std::size_t i = 0; i < history.still.size(); ++i) {
      if (std::fabs(history.midpoints[2 * i].table_rate_deg_s[kInnerAxis]) < 4.0) continue;
      ++turns;
      moved += history.nodes[i].table_deg[kOuterAxis] != history.nodes[i + 1].table_deg[kOuterAxis];
    }
    EXPECT_GT(turns, 800);
    EXPECT_LE(moved, turns / 100) << "seed " << seed;
  }
}

// The middle axis is horizontal, across z, however far it has turned.
TEST(ReferenceShare, IsNoneWhereTheTurningAxisIsAcrossTheChannel) {
  const Told told = Tell(Motion().Rest(20).ThereAndBack(kMiddleAxis, 60, 20).Rest(20), {}, 1);
  const std::vector<double> shares = SharesWhileTurning(told, kMiddleAxis);
  ASSERT_GT(shares.size(), 30U);
  for (const double share : shares) EXPECT_LT(share, 1e-3);
}

// By the mean over seeds, to within four standard errors of it and 2 %.
TEST(ReferenceNoise, IsWhatWasPutInWhateverElseTheStandDoes) {
  const Motion motion = Motion()
                            .Rest(30)
                            .ThereAndBack(kInnerAxis, 360, 20)
                            .ThereAndBack(kMiddleAxis, 80, 20)
                            .ThereAndBack(kMiddleAxis, 60, 10)
                            .ThereAndBack(kInnerAxis, 360, 30)
                            .Rest(30);
  BenchSensor sensor;
  double sum = 0.0, square = 0.0;
  constexpr int kSeeds = 12;
  for (int seed = 1; seed <= kSeeds; ++seed) {
    const Told told = Tell(motion, sensor, static_cast<std::uint64_t>(seed));
    const ChannelProblem problem(told.histories, kChannel, 1.0);
    const calibration::NoiseSearch search(problem.intervals(), problem.MakeBaseline().columns,
                                          problem.output_deg());
    const double s = search.Best()->noise.reference_deg;
    sum += s;
    square += s * s;
  }
  const double mean = sum / kSeeds;
  const double error = std::sqrt((square / kSeeds - mean * mean) / (kSeeds - 1));
  EXPECT_NEAR(mean, sensor.reading_deg, 4.0 * error + 0.02 * sensor.reading_deg);
}

TEST(Tails, OfANormalDistributionAreNotTakenForHeavyOnes) {
  constexpr double kValues = 1e4;
  const double expected = kValues * std::erfc(3.0 / std::sqrt(2.0));
  EXPECT_TRUE(std::isinf(calibration::FreedomOfTails(expected, kValues)));
  EXPECT_TRUE(std::isinf(calibration::FreedomOfTails(expected + std::sqrt(expected), kValues)));
}

TEST(Tails, HaveTheFreedomWhoseShareBeyondThreeTheyShow) {
  for (const double freedom : {5.0, 8.0, 15.0, 30.0}) {
    constexpr double kValues = 1e6;
    const double beyond = kValues * std::exp(calibration::LogHeavyTail(9.0, freedom));
    EXPECT_NEAR(calibration::FreedomOfTails(beyond, kValues), freedom, 1e-3 * freedom);
  }
}

TEST(Tails, AreHeavierThanNormalOnesFarOutAndWithoutLimitAreThem) {
  for (const double square : {16.0, 36.0, 100.0}) {
    EXPECT_GT(calibration::LogHeavyTail(square, 8.0), calibration::LogChiSquareTail(square, 1.0));
    EXPECT_NEAR(calibration::LogHeavyTail(square, 1e7), calibration::LogChiSquareTail(square, 1.0),
                1e-3 * square);
  }
}

// Three axes that creep are read 2 ms apart, nearer than two samples of the gyro. An interval whose
// noise is less than what it shares with its neighbours has no covariance, and no noise could be
// judged by it.
TEST(TheWalkThatNeighboursShare, LeavesAnIntervalAsMuch) {
  calibration::Collector collector;
  MeasurementInfo info;
  info.gyro_present = {true, true, true};
  info.reference = ReferenceKind::kStandAngles;
  info.stand_axis_present = {true, true, true};
  collector.OnInfo(info);
  std::mt19937_64 random(7);
  std::normal_distribution<double> normal;
  constexpr double kCreep_deg_s = 0.5;
  for (int sample = 0; sample < 12000; ++sample) {
    const double t_s = 0.005 * sample;
    const auto shown = [&] { return kCreep_deg_s + 0.02 * normal(random); };
    collector.OnGyro({.t_s = t_s, .xi = {shown(), shown(), shown()}});
    if (sample % 40 != 0) continue;
    for (int axis = 0; axis < 3; ++axis) {
      const double read_s = t_s + 0.0023 * axis;
      const double angle_deg = kCreep_deg_s * read_s;
      collector.OnAngle({.t_s = read_s, .axis = axis, .angle_deg = angle_deg});
    }
  }
  const Recording recording = collector.Take();
  const StateHistory history = MakeStateHistory(recording, {1.0, 1.0, 1.0}, true, {});
  bool close = false;
  for (std::size_t i = 0; i + 1 < history.nodes.size(); ++i) {
    const double length_s = history.nodes[i + 1].t_s - history.nodes[i].t_s;
    close = close || (length_s < 0.005 && !history.still[i]);
    EXPECT_LE(history.reference_walk_s[i] + history.reference_walk_s[i + 1],
              0.5 * length_s * (1.0 + 1e-9));
  }
  EXPECT_TRUE(close);
  const ChannelProblem problem({&history, 1}, kChannel, 1.0);
  const calibration::NoiseSearch search(problem.intervals(), problem.MakeBaseline().columns,
                                        problem.output_deg());
  const auto noise = search.Best();
  ASSERT_TRUE(noise.has_value());
  EXPECT_NEAR(noise->noise.angle_random_walk_deg_sqrt_s, 0.02 * std::sqrt(0.005), 1e-3);
}

TEST(ANoise, IsNotJudgedByValuesThatAreNoNumbers) {
  const std::vector<calibration::Interval> intervals(100, {.duration_s = 1.0, .still = true});
  Eigen::MatrixXd columns = Eigen::MatrixXd::Ones(100, 1);
  Eigen::VectorXd output = Eigen::VectorXd::LinSpaced(100, 0.0, 1.0);
  EXPECT_TRUE(calibration::NoiseSearch(intervals, columns, output).Best().has_value());
  output(50) = std::numeric_limits<double>::quiet_NaN();
  EXPECT_FALSE(calibration::NoiseSearch(intervals, columns, output).Best().has_value());
}

// Readings of a table that turns evenly, and of one that stands at many places, rounded to whole
// steps.
TEST(RoundingOfNoisyReadings, MakesNoLargerWaveThanIsSaid) {
  constexpr int kReadings = 200000, kAtRest = 20;
  std::mt19937_64 random(3);
  std::normal_distribution<double> normal;
  std::uniform_real_distribution<double> anywhere(0.0, 1.0);
  for (const double noise : {0.0, 0.1, 0.2, 0.3, 0.4}) {
    double in_phase = 0.0, changes = 0.0;
    for (int i = 0; i < kReadings; ++i) {
      const double angle = anywhere(random);
      const double error = std::round(angle + noise * normal(random)) - angle;
      in_phase += 2.0 * error * std::sin(2.0 * std::acos(-1.0) * angle) / kReadings;
    }
    for (int rest = 0; rest < kReadings / kAtRest; ++rest) {
      const double angle = anywhere(random);
      double before = std::round(angle + noise * normal(random));
      for (int i = 1; i < kAtRest; ++i) {
        const double reading = std::round(angle + noise * normal(random));
        changes += std::pow(reading - before, 2) / (2.0 * kReadings);
        before = reading;
      }
    }
    const double left = calibration::LeftOfRounding(changes, kReadings / kAtRest);
    const double said = calibration::WaveOfRounding_deg(1.0, left);
    const double made = std::fabs(in_phase);
    EXPECT_GT(said, 0.97 * made - 0.003) << noise;
    EXPECT_LT(said, 2.0 * made + 0.01) << noise;
  }
}

TEST(RoundingOfNoisyReadings, IsNothingWhereNothingIsRounded) {
  for (const double step_deg : {0.0, std::numeric_limits<double>::quiet_NaN()})
    EXPECT_EQ(calibration::WaveOfRounding_deg(step_deg, 1.0), 0.0);
}

// At two places between two steps least noise makes half of the readings another than the rest.
TEST(RoundingOfNoisyReadings, IsBelievedToBeNoiseAtManyPlacesAlone) {
  constexpr double kHalfAndHalf = 0.25;
  EXPECT_LT(calibration::LeftOfRounding(kHalfAndHalf, 1000), 0.01);
  EXPECT_GT(calibration::LeftOfRounding(kHalfAndHalf, 1), 0.8);
  EXPECT_EQ(calibration::LeftOfRounding(0.0, 1000), 1.0);
  // Readings on many steps are so at one place as well.
  EXPECT_LT(calibration::LeftOfRounding(0.5, 1), 1e-6);
  EXPECT_LT(calibration::LeftOfRounding(9.0, 1), 1e-6);
  EXPECT_EQ(calibration::LeftOfRounding(std::numeric_limits<double>::quiet_NaN(), 0), 1.0);
}

calibration::RestFlicker RestsOn(double step_deg, const std::vector<double>& angles_deg,
                                 double noise_steps, std::mt19937_64* random) {
  constexpr int kNodes = 60;
  std::normal_distribution<double> noise(0.0, noise_steps * step_deg);
  std::vector<calibration::Node> nodes;
  std::vector<std::size_t> rest_of;
  for (std::size_t rest = 0; rest < angles_deg.size(); ++rest) {
    for (int i = 0; i < kNodes; ++i) {
      const double angle_deg = angles_deg[rest] + (noise_steps > 0.0 ? noise(*random) : 0.0);
      calibration::Node node;
      node.table_deg[2] = step_deg * std::round(angle_deg / step_deg);
      node.mean.own_readings[2] = 1.0;
      node.mean.own_deg[2] = node.table_deg[2];
      nodes.push_back(node);
      rest_of.push_back(rest);
    }
  }
  return calibration::FlickerAtRest(nodes, rest_of, 2, step_deg);
}

std::vector<double> Anywhere(int places, std::mt19937_64* random) {
  std::uniform_real_distribution<double> anywhere(0.0, 360.0);
  std::vector<double> angles_deg;
  for (int i = 0; i < places; ++i) angles_deg.push_back(anywhere(*random));
  return angles_deg;
}

double WaveAlone_deg(const calibration::RestFlicker& rests) {
  return calibration::WaveOfRounding_deg(std::span(&rests, 1));
}

constexpr double kStep_deg = 360.0 / 8192.0;
constexpr double kFullWave_deg = kStep_deg / std::numbers::pi;

// What two rests leave open ten recordings of two rests know; steps in few digits are one step.
TEST(RoundingInSeveralRecordings, IsKnownByTheRestsOfAllOfThem) {
  constexpr double kNoise = 0.45;
  const double made_deg = kFullWave_deg * std::exp(-2.0 * std::pow(std::numbers::pi * kNoise, 2));
  int open_alone = 0;
  for (unsigned seed = 1; seed <= 30; ++seed) {
    std::mt19937_64 random(seed);
    std::vector<calibration::RestFlicker> recordings;
    for (int i = 0; i < 10; ++i) {
      const double step_deg = i % 2 == 0 ? kStep_deg : 0.044;
      recordings.push_back(RestsOn(step_deg, Anywhere(2, &random), kNoise, &random));
    }
    double most_alone_deg = 0.0;
    for (const auto& rests : recordings)
      most_alone_deg = std::max(most_alone_deg, WaveAlone_deg(rests));
    if (most_alone_deg > 6.0 * made_deg) ++open_alone;
    const double together_deg = calibration::WaveOfRounding_deg(recordings);
    EXPECT_LE(together_deg, most_alone_deg);
    EXPECT_GT(together_deg, 0.6 * made_deg) << "seed " << seed;
    EXPECT_LT(together_deg, 6.0 * made_deg) << "seed " << seed;
  }
  EXPECT_GT(open_alone, 24);
}

// Its own rests say that noise does not carry its readings over the steps.
TEST(RoundingInSeveralRecordings, IsThatOfAQuietOneBesideNoisyOnes) {
  for (const int quiet_places : {1, 2, 12}) {
    for (const double noise : {0.3, 0.35, 0.4, 0.5}) {
      for (unsigned seed = 1; seed <= 5; ++seed) {
        std::mt19937_64 random(seed);
        // In the middle of a step each.
        std::vector<double> quiet;
        for (int i = 0; i < quiet_places; ++i) quiet.push_back(kStep_deg * 100.0 * i);
        const std::vector<calibration::RestFlicker> recordings = {
            RestsOn(kStep_deg, Anywhere(20, &random), noise, &random),
            RestsOn(kStep_deg, quiet, 0.02, &random),
            RestsOn(kStep_deg, Anywhere(20, &random), noise, &random)};
        EXPECT_GT(calibration::WaveOfRounding_deg(recordings), 0.9 * kFullWave_deg)
            << quiet_places << " places beside " << noise << ", seed " << seed;
      }
    }
  }
}

// Between two steps the least noise makes the readings flicker: ten recordings that rest there say
// no more than one. An eighth of a turn later they are there again.
TEST(RoundingInSeveralRecordings, IsNoBetterKnownByTheSamePlaceAgain) {
  std::mt19937_64 random(1);
  std::vector<calibration::RestFlicker> recordings;
  for (int i = 0; i < 10; ++i) {
    const double edge_deg = kStep_deg * (i % 2 == 0 ? -0.5 : 0.5);
    recordings.push_back(
        RestsOn(kStep_deg, {edge_deg, 45.0 + edge_deg, 90.0 + edge_deg}, 0.02, &random));
  }
  EXPECT_GT(calibration::WaveOfRounding_deg(recordings), 0.8 * kFullWave_deg);
}

// Of one that never rests nothing is known, whatever the others show.
TEST(RoundingInSeveralRecordings, IsWholeWhereOneNeverRests) {
  std::mt19937_64 random(1);
  std::vector<calibration::RestFlicker> recordings = {
      RestsOn(kStep_deg, Anywhere(20, &random), 0.5, &random)};
  EXPECT_LT(calibration::WaveOfRounding_deg(recordings), 0.1 * kFullWave_deg);
  recordings.push_back(RestsOn(kStep_deg, {}, 0.5, &random));
  EXPECT_DOUBLE_EQ(calibration::WaveOfRounding_deg(recordings), kFullWave_deg);
}

// Nothing is known of a coarse encoder by the noise of a fine one; one without steps has no wave.
TEST(RoundingInSeveralRecordings, IsThatOfEachStep) {
  std::mt19937_64 random(1);
  const calibration::RestFlicker coarse =
      RestsOn(8.0 * kStep_deg, Anywhere(1, &random), 0.45, &random);
  const std::vector<calibration::RestFlicker> recordings = {
      RestsOn(kStep_deg, Anywhere(20, &random), 0.45, &random), coarse,
      RestsOn(std::numeric_limits<double>::quiet_NaN(), Anywhere(3, &random), 0.0, &random)};
  EXPECT_EQ(calibration::WaveOfRounding_deg(recordings), WaveAlone_deg(coarse));
}

}  // namespace
}  // namespace gyrobench::testing
