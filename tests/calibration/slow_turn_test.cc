// A table that turns slowly: what an angle that depends on the readings and on the gyro does beside
// what the gyro itself measures.
#include <gtest/gtest.h>

#include <Eigen/Core>
#include <cmath>
#include <cstdint>
#include <random>

#include "calibration/gls/noise_search.h"
#include "calibration/gls/scaled_ldlt.h"
#include "calibration/gls/whitener.h"
#include "calibration/signal/collector.h"
#include "calibration/state/state_history.h"
#include "calibration/trace/problem.h"
#include "tests/calibration/synthetic_bench.h"

namespace gyrobench::testing {
namespace {

using calibration::ChannelProblem;
using calibration::MakeStateHistory;
using calibration::NoiseModel;
using calibration::NoiseSearch;
using calibration::RawColumns;
using calibration::Recording;
using calibration::StateHistory;

constexpr std::size_t kTurned = 2;  // the channel z
constexpr double kSample_s = 0.01, kSpeed_deg_s = 2.0;

struct Noises {
  double walk_deg_sqrt_s, reading_deg;
};

// The inner axis turns evenly, z up, and is read with each sample of the gyro. The others have no
// column.
Recording TurnSlowly(const Noises& noises, std::uint64_t seed) {
  constexpr int kSamples = 60000;
  calibration::Collector collector;
  MeasurementInfo info;
  info.gyro_present = {true, true, true};
  info.reference = ReferenceKind::kStandAngles;
  info.stand_axis_present = {false, false, true};
  collector.OnInfo(info);
  std::mt19937_64 random(seed);
  std::normal_distribution<double> normal;
  const double scatter_deg_s = noises.walk_deg_sqrt_s / std::sqrt(kSample_s);
  for (int sample = 0; sample < kSamples; ++sample) {
    const double t_s = kSample_s * sample;
    collector.OnGyro({.t_s = t_s, .xi = {0.0, 0.0, kSpeed_deg_s + scatter_deg_s * normal(random)}});
    collector.OnAngle({.t_s = t_s,
                       .axis = kInnerAxis,
                       .angle_deg = kSpeed_deg_s * t_s + noises.reading_deg * normal(random)});
  }
  return collector.Take();
}

// Of the error D u of a term that follows the angle: what generalised least squares takes for the
// term, (D u)' V^-1 e, a node in steady motion.
double ScoreOfAngleError(const Noises& noises, std::uint64_t seed) {
  const Motion motion = Motion()
                            .Rest(20)
                            .ThereAndBack(kInnerAxis, 180, kSpeed_deg_s)
                            .ThereAndBack(kInnerAxis, 180, kSpeed_deg_s)
                            .ThereAndBack(kInnerAxis, 180, kSpeed_deg_s)
                            .Rest(20);
  BenchSensor sensor;
  sensor.angle_random_walk_deg_sqrt_s = noises.walk_deg_sqrt_s;
  sensor.reading_deg = noises.reading_deg;
  const SyntheticBench bench(motion, sensor);
  const Recording recording = bench.Measure({}, seed);
  const StateHistory history =
      MakeStateHistory(recording, calibration::RoughSensitivity(recording), true, {});
  const ChannelProblem problem({&history, 1}, kTurned, 1.0);
  const calibration::Whitener whitener(problem.intervals(),
                                       {noises.walk_deg_sqrt_s, 0.0, noises.reading_deg});
  const auto error_deg = [&](std::size_t node) {
    const calibration::SensorState& point = history.nodes[node];
    return point.table_deg[kInnerAxis] + point.own_part_deg[kInnerAxis] -
           bench.At(point.t_s).table.angle_deg[kInnerAxis];
  };
  Eigen::MatrixXd model = problem.MakeBaseline().columns;
  Eigen::MatrixXd both(problem.rows(), 2);
  both.col(0) = problem.output_deg();
  for (Eigen::Index i = 0; i < problem.rows(); ++i) {
    const std::size_t node = problem.row_refs()[static_cast<std::size_t>(i)].interval;
    both(i, 1) = error_deg(node + 1) - error_deg(node);
  }
  whitener.Apply(model);
  whitener.Apply(both);
  const Eigen::VectorXd left = calibration::Projection(model).Off(both.col(0));
  double sum = 0.0, rows = 0.0;
  constexpr Eigen::Index kAbout = 8;
  for (Eigen::Index i = kAbout; i + kAbout < problem.rows(); ++i) {
    const auto steady = [&](Eigen::Index row) {
      return std::fabs(problem.half(row, 0).table_rate_deg_s[kInnerAxis]) > 0.95 * kSpeed_deg_s;
    };
    if (!steady(i - kAbout) || !steady(i) || !steady(i + kAbout)) continue;
    sum += left(i) * both(i, 1);
    rows += 1.0;
  }
  EXPECT_GT(rows, 4000.0);
  return sum / rows;
}

// With the angle by the readings about it alone, which the gyro carries there, the score would be
// sqrt(q / (q + 4)) about, where q is N^2 T over the variance of a node's readings: 0.9, 0.5 and
// 0.2 here; by its own readings alone one less. The mean of four seeds scatters by 0.01 to 0.02.
TEST(TheErrorOfAnAngle, HasNoPartInWhatIsLeftOfTheGyro) {
  constexpr int kSeeds = 4;
  for (const Noises& noises : {Noises{0.0035, 0.001}, {0.0035, 0.004}, {0.0007, 0.002}}) {
    double sum = 0.0;
    for (std::uint64_t seed = 1; seed <= kSeeds; ++seed) sum += ScoreOfAngleError(noises, seed);
    EXPECT_NEAR(sum / kSeeds, 0.0, 0.07) << noises.reading_deg;
  }
}

TEST(AnAxisThatIsNotRead, HasNoErrorThatAChannelFeels) {
  const Recording recording = TurnSlowly({0.0035, 0.001}, 1);
  const StateHistory history = MakeStateHistory(recording, {1.0, 1.0, 1.0}, true, {});
  ASSERT_GT(history.nodes.size(), 1000U);
  for (std::size_t node = 2; node + 2 < history.nodes.size(); ++node)
    EXPECT_NEAR(history.ReferenceShare(node, {0.0, 0.0, 1.0}) * history.epochs[node].mean.readings,
                1.0, 1e-6);
}

// Intervals of 0.1 s of a gyro with white noise and a turning reference, and a column that has the
// output's own noise beside little of its own: only a large coefficient makes it say so.
struct OwnNoise {
  std::vector<calibration::Interval> intervals;
  Eigen::MatrixXd turned, column;
  Eigen::VectorXd output;
};

constexpr NoiseModel kTrue = {0.0035, 0.0, 0.0003};

OwnNoise WithOwnNoise(std::uint64_t seed) {
  constexpr Eigen::Index kRows = 4000;
  constexpr double kStep_s = 0.1, kOfColumn = 0.01;
  std::mt19937_64 random(seed);
  std::normal_distribution<double> normal;
  OwnNoise out{std::vector<calibration::Interval>(kRows, {.duration_s = kStep_s}),
               Eigen::MatrixXd(kRows, 2), Eigen::MatrixXd(kRows, 1), Eigen::VectorXd(kRows)};
  out.intervals.front().new_run = out.intervals.front().new_reference = true;
  double reading = kTrue.reference_deg * normal(random);
  for (Eigen::Index i = 0; i < kRows; ++i) {
    const double next = kTrue.reference_deg * normal(random);
    const double turned = i % 400 < 200 ? 0.2 : -0.2;
    const double walk = kTrue.angle_random_walk_deg_sqrt_s * std::sqrt(kStep_s) * normal(random);
    const double wave = std::sin(2e-3 * static_cast<double>(i));
    out.turned.row(i) << turned, kStep_s;
    out.output(i) = 1.01 * turned + 0.5 * kStep_s + walk - (next - reading);
    out.column(i, 0) = kOfColumn * (2e-3 * wave + walk);
    reading = next;
  }
  return out;
}

NoiseModel BestNoise(const OwnNoise& data, const RawColumns& column) {
  const std::vector<RawColumns> columns = {RawColumns(data.turned), column};
  const auto best = NoiseSearch(data.intervals, columns, data.output, 1e-9).Best({}, 1e-3);
  return best ? best->noise : NoiseModel{};
}

TEST(ALimitedCoefficient, KeepsAColumnFromTakingTheNoiseAway) {
  for (std::uint64_t seed = 1; seed <= 5; ++seed) {
    const OwnNoise data = WithOwnNoise(seed);
    const RawColumns column(data.column);
    const double n = kTrue.angle_random_walk_deg_sqrt_s;
    // The column is a hundredth of the noise: 100 of it would take all of it away.
    EXPECT_LT(BestNoise(data, column).angle_random_walk_deg_sqrt_s, 0.5 * n);
    EXPECT_NEAR(BestNoise(data, column.Limited(0.1)).angle_random_walk_deg_sqrt_s, n, 0.05 * n);
  }
}

TEST(ALimitedCoefficient, IsFreeFarFromItsLimitAndGoneWithALimitOfNothing) {
  const OwnNoise data = WithOwnNoise(7);
  const NoiseModel free = BestNoise(data, RawColumns(data.column));
  const NoiseModel wide = BestNoise(data, RawColumns(data.column).Limited(1e7));
  EXPECT_NEAR(wide.angle_random_walk_deg_sqrt_s, free.angle_random_walk_deg_sqrt_s,
              1e-3 * free.angle_random_walk_deg_sqrt_s);
  const auto without = NoiseSearch(data.intervals, data.turned, data.output).Best({}, 1e-3);
  ASSERT_TRUE(without.has_value());
  const NoiseModel none = BestNoise(data, RawColumns(data.column).Limited(1e-9));
  EXPECT_NEAR(none.angle_random_walk_deg_sqrt_s, without->noise.angle_random_walk_deg_sqrt_s,
              1e-3 * none.angle_random_walk_deg_sqrt_s);
  EXPECT_NEAR(none.reference_deg, without->noise.reference_deg, 0.02 * none.reference_deg);
}

// Nothing but the noise itself: without a limit all of it would be taken away.
TEST(ALimitedCoefficient, KeepsACopyOfTheNoiseFromTakingItAway) {
  OwnNoise data = WithOwnNoise(4);
  data.column = 0.01 * (data.output - data.turned * Eigen::Vector2d(1.01, 0.5));
  const double n = kTrue.angle_random_walk_deg_sqrt_s;
  // The reference's noise is as much as a tenth of it.
  EXPECT_NEAR(BestNoise(data, RawColumns(data.column).Limited(0.1)).angle_random_walk_deg_sqrt_s, n,
              0.1 * n);
}

// Of forty columns of noise that are held next to 0 and a hundred rows: they take no freedom.
TEST(ALimitedCoefficient, TakesNoFreedomWhereTheLimitSaysIt) {
  constexpr Eigen::Index kRows = 100, kColumns = 40;
  double square = 0.0;
  constexpr int kSeeds = 50;
  for (std::uint64_t seed = 1; seed <= kSeeds; ++seed) {
    std::mt19937_64 random(seed);
    std::normal_distribution<double> normal;
    std::vector<calibration::Interval> intervals(kRows, {.duration_s = 1.0, .still = true});
    intervals.front().new_run = true;
    const auto any = [&] { return normal(random); };
    const Eigen::MatrixXd held = Eigen::MatrixXd::NullaryExpr(kRows, kColumns, any);
    const Eigen::VectorXd output = Eigen::VectorXd::NullaryExpr(kRows, any);
    const std::vector<RawColumns> columns = {RawColumns(Eigen::MatrixXd::Ones(kRows, 1)),
                                             RawColumns(held).Limited(1e-3)};
    const NoiseSearch search(intervals, columns, output, 1e-9, 0.0);
    square += std::pow(search.Best({}, 1e-3)->noise.angle_random_walk_deg_sqrt_s, 2) / kSeeds;
  }
  // 1 to within four standard errors and what the bias random walk takes.
  EXPECT_NEAR(square, 1.0, 4.0 * std::sqrt(2.0 / (kRows * kSeeds)) + 0.05);
}

// A column of next to nothing, whose coefficient by least squares is far beyond its limit: the
// products of the columns must not lose their digits by it.
TEST(ALimitedCoefficient, CostsNoDigitsWhereTheDataHardlyTellIt) {
  OwnNoise data = WithOwnNoise(3);
  const RawColumns column(Eigen::MatrixXd(1e-9 * data.column));
  const NoiseModel noise = BestNoise(data, column.Limited(0.1));
  EXPECT_NEAR(noise.angle_random_walk_deg_sqrt_s, kTrue.angle_random_walk_deg_sqrt_s,
              0.05 * kTrue.angle_random_walk_deg_sqrt_s);
}

// Over many rows what a column takes from the noise outweighs any limit: one whose coefficient can
// not be is left out, and the noise is what it is without it. A column that says something true
// stays.
TEST(AColumnWhoseCoefficientCannotBe, IsLeftOutOfTheNoise) {
  const OwnNoise data = WithOwnNoise(5);
  const std::vector<RawColumns> without = {RawColumns(data.turned)};
  std::vector<RawColumns> with = without;
  // A hundred times the column is what the output has of it: the limit is a tenth of that.
  with.push_back(RawColumns(data.column).Limited(10.0));
  NoiseSearch alone(data.intervals, without, data.output, 1e-9);
  NoiseSearch beside(data.intervals, with, data.output, 1e-9);
  ASSERT_EQ(beside.independent(), alone.independent() + 1);
  const auto expected = alone.BestPlausible({}, 1e-3), found = beside.BestPlausible({}, 1e-3);
  ASSERT_TRUE(expected && found);
  EXPECT_EQ(beside.independent(), alone.independent());
  EXPECT_NEAR(found->noise.angle_random_walk_deg_sqrt_s,
              expected->noise.angle_random_walk_deg_sqrt_s,
              2e-3 * expected->noise.angle_random_walk_deg_sqrt_s);
  EXPECT_NEAR(found->deviance, expected->deviance, 1e-3);

  with.back() = RawColumns(data.column).Limited(100.0);
  NoiseSearch stays(data.intervals, with, data.output, 1e-9);
  ASSERT_TRUE(stays.BestPlausible({}, 1e-3));
  EXPECT_EQ(stays.independent(), alone.independent() + 1);
}

}  // namespace
}  // namespace gyrobench::testing
