#include "calibration/gls/interval_gls.h"

#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <memory>
#include <numeric>
#include <random>

#include "calibration/gls/noise_fit.h"
#include "calibration/gls/white_products.h"
#include "calibration/gls/whitener.h"
#include "tests/calibration/dense_gls.h"

namespace gyrobench::calibration {
namespace {

using gyrobench::testing::DenseCovariance;
using gyrobench::testing::DenseInterval;
using gyrobench::testing::DenseSolution;
using gyrobench::testing::SolveDense;

// The same random problem, once as a series and once as dense matrices.
struct Problem {
  IntervalSeries series{4};
  std::vector<DenseInterval> dense;
  Eigen::MatrixXd x;
  Eigen::VectorXd y;
};

Problem Draw(std::mt19937* random, int rows) {
  std::uniform_real_distribution<double> uniform(0.0, 1.0);
  std::normal_distribution<double> normal;
  Problem out;
  out.x.resize(rows, 3);
  out.y.resize(rows);
  double t = 0.0;
  int angles = 0, current = angles++;
  for (int i = 0; i < rows; ++i) {
    Interval interval;
    interval.duration_s = 0.05 + uniform(*random);
    interval.still = uniform(*random) < 0.5;
    if (i > 0 && uniform(*random) < 0.2) interval.gap_before_s = 3 * uniform(*random);
    interval.new_reference = i == 0 || uniform(*random) < 0.15;
    if (interval.new_reference && i > 0) current = angles++;
    t += interval.gap_before_s;
    DenseInterval dense{t, t + interval.duration_s};
    if (!interval.still) {
      dense.begin_angle = current;
      dense.end_angle = current = angles++;
    }
    t = dense.end_s;
    out.dense.push_back(dense);
    double* row = out.series.Add(interval);
    row[0] = out.x(i, 0) = interval.still ? 0.0 : 10 * normal(*random);
    row[1] = out.x(i, 1) = interval.duration_s;
    row[2] = out.x(i, 2) = normal(*random);
    row[3] = out.y(i) = normal(*random) + 3 * out.x(i, 0);
  }
  return out;
}

const std::vector<int> kRegressors = {0, 1, 2};

void ExpectAgreement(const Problem& problem, const NoiseModel& noise) {
  const WhiteGram gram = Whiten(problem.series, noise);
  const GlsSolution solution = Solve(gram, kRegressors, 3);
  ASSERT_TRUE(solution.solvable);
  const gyrobench::testing::DenseNoise same = {
      noise.angle_random_walk_deg_sqrt_s, noise.bias_random_walk_deg_s_sqrt_s, noise.reference_deg};
  const DenseSolution dense =
      SolveDense(DenseCovariance(problem.dense, same), problem.x, problem.y);
  for (Eigen::Index i = 0; i < 3; ++i) {
    const auto index = static_cast<std::size_t>(i);
    EXPECT_NEAR(solution.coefficients[index], dense.coefficients(i),
                1e-9 * (1 + std::fabs(dense.coefficients(i))));
    for (Eigen::Index j = 0; j < 3; ++j) {
      EXPECT_NEAR(solution.covariance[index * 3 + static_cast<std::size_t>(j)],
                  dense.covariance(i, j),
                  1e-9 * std::sqrt(dense.covariance(i, i) * dense.covariance(j, j)));
    }
  }
  EXPECT_NEAR(Deviance(gram, solution), dense.deviance, 1e-9 * std::fabs(dense.deviance));
  EXPECT_NEAR(RestrictedDeviance(gram, solution), dense.restricted_deviance,
              1e-9 * std::fabs(dense.restricted_deviance));
}

TEST(IntervalGls, AgreesWithDenseLeastSquaresForRandomSequences) {
  std::mt19937 random(11);
  std::uniform_real_distribution<double> exponent(-2.0, 1.0);
  for (int trial = 0; trial < 200; ++trial) {
    const Problem problem = Draw(&random, 12 + trial % 30);
    ExpectAgreement(problem, {std::pow(10.0, exponent(random)), std::pow(10.0, exponent(random)),
                              std::pow(10.0, exponent(random))});
  }
}

TEST(IntervalGls, AgreesWithDenseLeastSquaresWhenANoiseIsZero) {
  std::mt19937 random(12);
  for (int trial = 0; trial < 50; ++trial) {
    const Problem problem = Draw(&random, 25);
    ExpectAgreement(problem, {0.3, 0.0, 0.0});
    ExpectAgreement(problem, {0.3, 0.2, 0.0});
    ExpectAgreement(problem, {0.3, 0.0, 0.5});
  }
}

// The mean bias is the best linear predictor: computed densely from the joint covariance of outputs
// and walk.
TEST(IntervalGls, AveragesTheBiasAsDensePredictionDoes) {
  std::mt19937 random(13);
  const NoiseModel noise = {0.2, 0.3, 0.4};
  for (int trial = 0; trial < 30; ++trial) {
    const Problem problem = Draw(&random, 20);
    GlsFit fit;
    FitOptions options;
    options.regressors = kRegressors;
    options.output = 3;
    fit.walk = IntegrateWalk(problem.series, Whitener(problem.series.intervals(), noise));
    fit.solution = Solve(Whiten(problem.series, noise), kRegressors, 3);
    const MeanBias mean = AverageBias(fit, options, 1);

    // Cov(int b over all, y_i), and its variance, from the walk's part of the covariance alone.
    const Eigen::MatrixXd walk = DenseCovariance(problem.dense, {0.0, 0.3, 0.0});
    const Eigen::MatrixXd v = DenseCovariance(problem.dense, {0.2, 0.3, 0.4});
    const Eigen::VectorXd c = walk.rowwise().sum();
    const DenseSolution dense = SolveDense(v, problem.x, problem.y);
    const Eigen::VectorXd weight = v.llt().solve(c);
    const double t = problem.x.col(1).sum();
    const double expected =
        dense.coefficients(1) + weight.dot(problem.y - problem.x * dense.coefficients) / t;
    Eigen::VectorXd direction = -problem.x.transpose() * weight / t;
    direction(1) += 1.0;
    const double variance =
        (walk.sum() - c.dot(weight)) / (t * t) + direction.dot(dense.covariance * direction);
    EXPECT_NEAR(mean.value, expected, 1e-9);
    EXPECT_NEAR(mean.variance, variance, 1e-9);
  }
}

TEST(IntervalGls, SaysWhenRegressorsAreNotIndependent) {
  std::mt19937 random(14);
  Problem problem = Draw(&random, 20);
  for (std::size_t i = 0; i < problem.series.rows(); ++i)
    problem.series.row(i)[2] = 2 * problem.series.row(i)[1];
  EXPECT_FALSE(Solve(Whiten(problem.series, {1, 0.1, 0.1}), kRegressors, 3).solvable);
}

TEST(IntervalGls, WhitenedRowsAndProductsAreTheSameThingForManyColumns) {
  std::mt19937 random(15);
  std::normal_distribution<double> normal;
  const int columns = 40;
  IntervalSeries series(columns);
  for (int i = 0; i < 150; ++i) {
    double* row = series.Add({0.1, 0.0, i % 3 == 0, i == 0});
    for (int j = 0; j < columns; ++j) row[j] = normal(random);
  }
  const NoiseModel noise = {0.1, 0.2, 0.3};
  const WhiteGram gram = Whiten(series, noise);
  Eigen::MatrixXd white = series.values();
  Whitener(series.intervals(), noise).Apply(white);
  const Eigen::MatrixXd expected = white.transpose() * white;
  for (int i = 0; i < columns; ++i) {
    for (int j = 0; j < columns; ++j)
      EXPECT_NEAR(gram.products(i, j), expected(i, j), 1e-10 * expected(i, i));
  }
}

// Several runs, each of which some columns, scattered among the others, are not 0 in alone.
TEST(IntervalGls, ProductsAreTheSameWhereColumnsActInOneRunAlone) {
  std::mt19937 random(16);
  std::normal_distribution<double> normal;
  constexpr int kColumns = 37, kRuns = 4, kRows = 300;
  Eigen::MatrixXd raw = Eigen::MatrixXd::Zero(kRuns * kRows, kColumns);
  std::vector<Interval> intervals;
  for (int i = 0; i < kRuns * kRows; ++i) {
    intervals.push_back({0.1, 0.0, i % 3 == 0, i % kRows == 0, i > 0 && i % kRows == 0});
    for (int j = 0; j < kColumns; ++j)
      if (j % 3 == 0 || j % kRuns == i / kRows) raw(i, j) = normal(random);
  }
  const ColumnsInChunks columns(raw);
  const Eigen::MatrixXd products = ProductsUnder(intervals, columns, {0.1, 0.2, 0.3}).products;
  Eigen::MatrixXd white = raw;
  Whitener(intervals, {0.1, 0.2, 0.3}).Apply(white);
  EXPECT_TRUE(products.isApprox(white.transpose() * white, 1e-12));
}

// What a search leaves: some columns, and the last one without what others explain of it. The
// second stretch of rows has no column but the last, the third one that does not stay.
TEST(IntervalGls, ColumnsThatStayAndTheLastWithOthersAddedAreThoseOfTheWholeMatrix) {
  std::mt19937 random(19);
  std::normal_distribution<double> normal;
  constexpr Eigen::Index kRows = 3 * kStretchRows - 7, kColumns = 6;
  RowMajor raw(kRows, kColumns);
  for (double& value : raw.reshaped()) value = normal(random);
  raw.block(kStretchRows, 0, kStretchRows, kColumns - 1).setZero();
  raw.block(2 * kStretchRows, 0, kStretchRows - 7, 3).setZero();
  raw.block(2 * kStretchRows, 4, kStretchRows - 7, 1).setZero();
  const Eigen::VectorXd times{{2.0, 0.0, -0.5, 3.0, 1.0}};
  const std::vector<Eigen::Index> stay = {0, 1, 4};
  RowMajor expected(kRows, 4);
  expected << raw(Eigen::all, stay), raw.col(5) + raw.leftCols(5) * times;
  const std::vector<Interval> intervals(kRows, Interval{.duration_s = 0.1});
  const NoiseModel noise = {0.1, 0.2, 0.3};
  const ColumnsInChunks left = ColumnsInChunks(raw).WithLastPlus(times, stay);
  EXPECT_EQ(left.rows(), kRows);
  EXPECT_EQ(left.cols(), 4);
  EXPECT_TRUE(ProductsUnder(intervals, left, noise)
                  .products.isApprox(
                      ProductsUnder(intervals, ColumnsInChunks(expected), noise).products, 1e-12));
}

// More noises than pass side by side, and one that is left over. What a trace says may not depend
// on which of them pass together.
TEST(IntervalGls, NoisesThatPassSideBySideGiveWhatEachGivesAlone) {
  std::mt19937 random(18);
  std::normal_distribution<double> normal;
  constexpr Eigen::Index kRows = 700;
  std::vector<Interval> intervals;
  for (Eigen::Index i = 0; i < kRows; ++i) {
    const double gap_s = i % 90 == 0 ? 1.5 : 0.0;
    intervals.push_back(
        {0.1, gap_s, i % 7 < 3, i % 50 == 0, i > 0 && i % 300 == 0, 0.8, 0.7, 0.01, 0.02});
  }
  Eigen::MatrixXd raw(kRows, 11);
  for (double& value : raw.reshaped()) value = normal(random);
  const ColumnsInChunks columns(raw);
  std::vector<NoiseModel> noises;
  for (int k = 0; k < 9; ++k) noises.push_back({0.1 + 0.1 * k, 0.05 * k, 0.3 / (1.0 + k)});
  const std::vector<WhiteProducts> together = ProductsUnder(intervals, columns, noises);
  ASSERT_EQ(together.size(), noises.size());
  for (std::size_t k = 0; k < noises.size(); ++k) {
    const WhiteProducts alone = ProductsUnder(intervals, columns, noises[k]);
    EXPECT_EQ(together[k].products, alone.products) << k;
    EXPECT_EQ(together[k].log_det, alone.log_det) << k;
  }
}

// Raw columns of a whole and of a part of its rows, more of them and more rows than pass together.
TEST(IntervalGls, RawColumnsBecomeWhiteWhereTheyAreWanted) {
  std::mt19937 random(17);
  std::normal_distribution<double> normal;
  constexpr Eigen::Index kRows = 2500;
  std::vector<Interval> intervals;
  auto rows = std::make_shared<std::vector<Eigen::Index>>();
  for (Eigen::Index i = 0; i < kRows; ++i) {
    intervals.push_back({0.1, 0.0, i % 3 == 0, i == 0, i > 0 && i % 900 == 0});
    rows->push_back(2 * i);
  }
  Eigen::MatrixXd whole(kRows, 11), twice(2 * kRows, 3);
  for (double& value : whole.reshaped()) value = normal(random);
  for (double& value : twice.reshaped()) value = normal(random);
  const Whitener whitener(intervals, {0.1, 0.2, 0.3});
  Eigen::MatrixXd white(kRows, 14);
  const std::vector<RawColumns> raw = {RawColumns(whole), RawColumns(twice).Part(rows)};
  whitener.Whiten(raw, white);
  for (Eigen::Index j = 0; j < white.cols(); ++j) {
    Eigen::MatrixXd alone =
        j < 11 ? whole.col(j) : Eigen::MatrixXd(twice(*rows, Eigen::all).col(j - 11));
    whitener.Apply(alone);
    EXPECT_TRUE(white.col(j).isApprox(alone.col(0), 1e-14)) << j;
  }
}

// Outputs drawn from the model itself: a stop-and-go run.
IntervalSeries DrawRun(std::mt19937* random, int turns, const NoiseModel& noise, double unit) {
  std::normal_distribution<double> normal;
  IntervalSeries series(3);
  double bias = 0.0, error = noise.reference_deg * normal(*random);
  for (int i = 0; i < 4 * turns; ++i) {
    Interval interval{i % 4 == 3 ? 0.5 : 1.0, 0.0, i % 4 != 3, i == 0};
    double* row = series.Add(interval);
    const double dt = interval.duration_s;
    double y = 0.3 * dt + noise.angle_random_walk_deg_sqrt_s * std::sqrt(dt) * normal(*random);
    // Exact pair of the walk's end value and integral.
    const double a = normal(*random), b = normal(*random), k = noise.bias_random_walk_deg_s_sqrt_s;
    y += bias * dt + k * std::pow(dt, 1.5) * (0.5 * a + b / std::sqrt(12.0));
    bias += k * std::sqrt(dt) * a;
    if (!interval.still) {
      row[0] = 9.0;
      const double next = noise.reference_deg * normal(*random);
      y += 1.01 * 9.0 - (next - error);
      error = next;
    }
    row[1] = dt;
    row[2] = unit * y;
  }
  return series;
}

FitOptions RunOptions() {
  FitOptions options;
  options.regressors = {0, 1};
  options.rest_regressors = {1};
  options.output = 2;
  return options;
}

// 40 runs: the means of the estimates lie within 5 standard errors of the truth.
TEST(NoiseFit, FindsTheNoiseThatMadeTheData) {
  std::mt19937 random(21);
  const NoiseModel truth = {0.0035, 0.001, 0.0144};
  const int runs = 40;
  std::vector<double> n, k, s;
  for (int i = 0; i < runs; ++i) {
    const GlsFit fit = FitIntervals(DrawRun(&random, 60, truth, 1.0), RunOptions());
    ASSERT_TRUE(fit.solvable);
    n.push_back(fit.noise.angle_random_walk_deg_sqrt_s);
    k.push_back(fit.noise.bias_random_walk_deg_s_sqrt_s);
    s.push_back(fit.noise.reference_deg);
  }
  auto expect_mean = [&](const std::vector<double>& values, double expected) {
    double sum = 0, square = 0;
    for (const double v : values) sum += v, square += v * v;
    const double mean = sum / runs, deviation = std::sqrt(square / runs - mean * mean);
    EXPECT_NEAR(mean, expected, 5 * deviation / std::sqrt(runs));
    EXPECT_LT(deviation, 0.35 * expected);
  };
  expect_mean(n, truth.angle_random_walk_deg_sqrt_s);
  expect_mean(k, truth.bias_random_walk_deg_s_sqrt_s);
  expect_mean(s, truth.reference_deg);
}

TEST(NoiseFit, ScalesWithTheUnitOfTheOutput) {
  std::mt19937 random(22), same(22);
  const NoiseModel truth = {0.0035, 0.001, 0.0144};
  const GlsFit one = FitIntervals(DrawRun(&random, 40, truth, 1.0), RunOptions());
  const GlsFit thousand = FitIntervals(DrawRun(&same, 40, truth, 1000.0), RunOptions());
  ASSERT_TRUE(one.solvable && thousand.solvable);
  EXPECT_NEAR(thousand.solution.coefficients[0], 1000 * one.solution.coefficients[0], 1e-6);
  EXPECT_NEAR(thousand.noise.angle_random_walk_deg_sqrt_s / one.noise.angle_random_walk_deg_sqrt_s,
              1000, 1e-3);
  EXPECT_NEAR(thousand.solution.variance(0) / one.solution.variance(0), 1e6, 1.0);
}

TEST(NoiseFit, FindsNoNoiseWhereThereIsNone) {
  std::mt19937 random(23);
  const GlsFit fit = FitIntervals(DrawRun(&random, 60, {0.0035, 0.0, 0.0}, 1.0), RunOptions());
  ASSERT_TRUE(fit.solvable);
  EXPECT_LT(fit.noise.reference_deg, 0.002);
  EXPECT_LT(fit.noise.bias_random_walk_deg_s_sqrt_s, 3e-4);
  EXPECT_NEAR(fit.noise.angle_random_walk_deg_sqrt_s, 0.0035, 0.0007);
}

// Rest, turn, rest: one number is left over to see the gyro's noise by. The 95 % interval has to
// hold the truth all the same; 350 of 400 and fewer: once in 200 million. And it is no wider than
// it has to be: where the reference's error is the most of it half of all standard errors are at
// most the estimates' own scatter, and where the gyro's is, Student's t makes them 1.7 times that;
// a quarter more is for the scatter of 400 runs.
TEST(NoiseFit, OneTurnBetweenTwoRestsIsSolvedWhereTheReferencesErrorIsKnown) {
  constexpr double kTruth = 1.01, kNormalHalfWidth = 1.959964;
  std::mt19937 random(25);
  std::normal_distribution<double> normal;
  for (const auto& [walk, usual] : {std::pair(0.0035, 1.04), std::pair(0.1, 1.66)}) {
    double square = 0.0;
    std::vector<double> errors;
    int held = 0;
    for (int run = 0; run < 400; ++run) {
      IntervalSeries series(3);
      for (const double turn_deg : {0.0, 90.0, 0.0}) {
        const double duration_s = turn_deg > 0.0 ? 4.5 : 1.0;
        double* row = series.Add({duration_s, 0.0, turn_deg == 0.0, turn_deg > 0.0});
        row[0] = turn_deg;
        row[1] = duration_s;
        row[2] =
            kTruth * turn_deg + 0.3 * duration_s + walk * std::sqrt(duration_s) * normal(random);
        if (turn_deg > 0.0) row[2] += 0.0144 * (normal(random) - normal(random));
      }
      FitOptions options = RunOptions();
      options.known_reference_deg = 0.0144;
      const GlsFit fit = FitIntervals(series, options);
      ASSERT_TRUE(fit.solvable);
      const double error = std::sqrt(fit.solution.variance(0)) * fit.inflation[0];
      const double off = fit.solution.coefficients[0] - kTruth;
      held += std::fabs(off) < kNormalHalfWidth * error ? 1 : 0;
      square += off * off;
      errors.push_back(error);
    }
    std::ranges::sort(errors);
    const double scatter = std::sqrt(square / static_cast<double>(errors.size()));
    EXPECT_GT(held, 350) << walk;
    EXPECT_GT(errors.front(), 0.9 * 0.0144 * std::sqrt(2.0) / 90.0)
        << "what the reference leaves open";
    EXPECT_LT(errors[errors.size() / 2], 1.25 * usual * scatter) << walk;
  }
}

// The white residuals of a fit have unit variance and no memory.
TEST(NoiseFit, LeavesWhiteResiduals) {
  std::mt19937 random(24);
  const GlsFit fit =
      FitIntervals(DrawRun(&random, 200, {0.0035, 0.001, 0.0144}, 1.0), RunOptions());
  const double n = static_cast<double>(fit.white_residuals.size());
  double square = 0, next = 0;
  for (Eigen::Index i = 1; i < fit.white_residuals.size(); ++i) {
    square += std::pow(fit.white_residuals(i), 2);
    next += fit.white_residuals(i) * fit.white_residuals(i - 1);
  }
  EXPECT_NEAR(square / n, 1.0, 0.02);
  EXPECT_NEAR(next / n, 0.0, 5 / std::sqrt(n));
}

}  // namespace
}  // namespace gyrobench::calibration
