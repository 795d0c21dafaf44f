#include "calibration/gls/filled_columns.h"

#include <gtest/gtest.h>

#include <Eigen/LU>
#include <cmath>
#include <limits>
#include <random>

#include "calibration/gls/scaled_ldlt.h"
#include "calibration/gls/whitener.h"

namespace gyrobench::calibration {
namespace {

constexpr Eigen::Index kLength = 3 * kStretchRows + 17, kParts = 4, kCommon = 3;

// Each part of the rows has a constant of its own, as a power-on has; the last columns belong to
// all.
Eigen::MatrixXd Parts(std::mt19937* random) {
  std::normal_distribution<double> normal;
  Eigen::MatrixXd out = Eigen::MatrixXd::Zero(kLength, kParts + kCommon);
  for (Eigen::Index i = 0; i < kLength; ++i) {
    out(i, i * kParts / kLength) = 1.0;
    for (Eigen::Index j = 0; j < kCommon; ++j) out(i, kParts + j) = normal(*random);
  }
  return out;
}

void ExpectNear(const Eigen::MatrixXd& left, const Eigen::MatrixXd& right) {
  ASSERT_EQ(left.rows(), right.rows());
  ASSERT_EQ(left.cols(), right.cols());
  ASSERT_TRUE(left.allFinite());
  EXPECT_LT((left - right).cwiseAbs().maxCoeff(), 1e-11 * right.cwiseAbs().maxCoeff());
}

TEST(FilledColumns, NamesWhatIsNotZeroInAStretch) {
  Eigen::MatrixXd stretch = Eigen::MatrixXd::Zero(5, 4);
  stretch(2, 1) = 1e-300;
  stretch(3, 2) = std::numeric_limits<double>::quiet_NaN();
  stretch(4, 3) = -1.0;
  EXPECT_EQ(FilledColumns(stretch), (std::vector<Eigen::Index>{1, 2, 3}));
}

TEST(FilledColumns, ProductsAreThoseOfTheWholeColumns) {
  std::mt19937 random(5);
  const Eigen::MatrixXd parts = Parts(&random), others = Eigen::MatrixXd::Random(kLength, 9);
  ExpectNear(Gram(parts), parts.transpose() * parts);
  ExpectNear(TransposeTimes(parts, others), parts.transpose() * others);
  const Eigen::MatrixXd coefficients = Eigen::MatrixXd::Random(parts.cols(), others.cols());
  Eigen::MatrixXd left = others;
  TakeOff(parts, coefficients, &left);
  ExpectNear(left, others - parts * coefficients);
}

TEST(FilledColumns, AValueThatIsNotANumberStaysOne) {
  std::mt19937 random(6);
  Eigen::MatrixXd parts = Parts(&random);
  const Eigen::MatrixXd ones = Eigen::MatrixXd::Ones(kLength, 1);
  parts(kLength / 2 + 3, 0) = std::numeric_limits<double>::quiet_NaN();
  EXPECT_TRUE(std::isnan(Gram(parts)(0, 0)));
  EXPECT_TRUE(std::isnan(TransposeTimes(parts, ones)(0, 0)));
}

TEST(FilledColumns, WhatIsLeftOfColumnsIsAtRightAnglesToTheModel) {
  std::mt19937 random(7);
  const Eigen::MatrixXd model = Parts(&random);
  const Eigen::MatrixXd left = Projection(model).Off(Eigen::MatrixXd::Random(kLength, 5));
  EXPECT_LT((model.transpose() * left).cwiseAbs().maxCoeff(), 1e-10);
}

TEST(ScaledLdlt, SquaresAreThoseOfTheInverse) {
  const Eigen::MatrixXd columns = Eigen::MatrixXd::Random(30, 6);
  const Eigen::VectorXd units =
      Eigen::VectorXd::LinSpaced(6, -6, 6).unaryExpr([](double x) { return std::pow(10.0, x); });
  const Eigen::MatrixXd gram = columns.transpose() * columns;
  const Eigen::MatrixXd right = Eigen::MatrixXd::Random(6, 11);
  // Units of the columns change nothing that is said in the same units.
  const ScaledLdlt factor(units.asDiagonal() * gram * units.asDiagonal());
  const Eigen::VectorXd squares = factor.Squares(units.asDiagonal() * right);
  ExpectNear(squares, (right.transpose() * gram.inverse() * right).diagonal());
}

TEST(ScaledLdlt, WithoutOthersIsThatPartOfTheInverse) {
  std::mt19937 random(8);
  const Eigen::MatrixXd gram = Gram(Parts(&random));
  const Eigen::VectorXd units =
      Eigen::VectorXd::LinSpaced(gram.cols(), -6, 6).unaryExpr([](double x) {
        return std::pow(10.0, x);
      });
  const Eigen::MatrixXd products = units.asDiagonal() * gram * units.asDiagonal();
  const Eigen::MatrixXd inverse = gram.inverse();
  const Eigen::MatrixXd right = Eigen::MatrixXd::Random(gram.cols(), 9);
  for (const std::vector<Eigen::Index>& some :
       {std::vector<Eigen::Index>{0, 4, 5, 6}, {1, 2, 4, 5, 6}, {0, 1, 2, 3, 4, 5, 6}, {3}}) {
    const Eigen::MatrixXd part = right(some, Eigen::all);
    const Eigen::MatrixXd in_units = units(some).asDiagonal() * part;
    ExpectNear(WithoutOthers(products, some).Squares(in_units),
               (part.transpose() * inverse(some, some) * part).diagonal());
  }
}

// The sum of all parts' constants is the last column: one of them leaves nothing of the other.
TEST(ScaledLdlt, AColumnThatTheOthersMakeUpSaysNothing) {
  std::mt19937 random(9);
  Eigen::MatrixXd columns = Parts(&random);
  columns.rightCols(1).setOnes();
  const Eigen::Index last = columns.cols() - 1;
  const Eigen::MatrixXd own = Eigen::MatrixXd::Identity(1, 1) * 1e-6;
  EXPECT_LT(WithoutOthers(Gram(columns), {last}).Square(own), 1e-12);
}

// Two power-ons, longer than a stretch, rests and turns in each.
std::vector<Interval> TwoRuns() {
  std::vector<Interval> out;
  for (Eigen::Index i = 0; i < 2 * kStretchRows + 50; ++i) {
    Interval interval;
    interval.duration_s = 0.1 + 0.05 * static_cast<double>(i % 3);
    interval.still = i / 20 % 2 == 0;
    interval.new_run = interval.new_reference = i == 0 || i == kStretchRows + 30;
    out.push_back(interval);
  }
  return out;
}

// A shock's score is the product of the white column with what the shock itself becomes.
TEST(Whitener, ScoresAreProductsWithWhiteShocks) {
  const std::vector<Interval> intervals = TwoRuns();
  const auto n = static_cast<Eigen::Index>(intervals.size());
  const Eigen::Index second = kStretchRows + 30;
  const Whitener whitener(intervals, {0.01, 0.003, 0.02});
  Eigen::MatrixXd columns = Eigen::MatrixXd::Zero(n, 3);
  columns.col(0).head(second).setOnes();
  columns.col(1).tail(n - second).setRandom();
  columns.col(2).setRandom();
  whitener.Apply(columns);
  const Whitener::Shocks scores = whitener.Scores(columns);
  for (const Eigen::Index row : {Eigen::Index{0}, Eigen::Index{7}, Eigen::Index{255}, second - 1,
                                 second, second + 100, n - 1}) {
    const Eigen::Index end = row < second ? second : n;
    Eigen::MatrixXd shocks = Eigen::MatrixXd::Zero(n, 2);
    for (Eigen::Index i = row; i < end; ++i)
      shocks(i, 0) = intervals[static_cast<std::size_t>(i)].duration_s;
    shocks(row, 1) = 1.0;
    whitener.Apply(shocks);
    SCOPED_TRACE(row);
    const Eigen::RowVectorXd bias = shocks.col(0).transpose() * columns;
    const Eigen::RowVectorXd output = shocks.col(1).transpose() * columns;
    const double size = 1.0 + bias.norm() + output.norm();
    EXPECT_LT((scores.bias.row(row) - bias).norm(), 1e-9 * size);
    EXPECT_LT((scores.output.row(row) - output).norm(), 1e-9 * size);
    EXPECT_NEAR(scores.bias_information(row) / shocks.col(0).squaredNorm(), 1.0, 1e-9);
    EXPECT_NEAR(scores.output_information(row) / shocks.col(1).squaredNorm(), 1.0, 1e-9);
  }
}

// What comes of a column goes on where the column itself is 0, for longer than a piece of rows that
// pass together: what is added to a column that is filled everywhere shows it.
TEST(Whitener, AColumnIsRememberedWhereItIsZero) {
  constexpr Eigen::Index kRowsOfAll = 5000;
  std::vector<Interval> intervals(kRowsOfAll);
  for (Interval& interval : intervals) interval.duration_s = 0.1;
  intervals.front().new_run = intervals.front().new_reference = true;
  const Whitener whitener(intervals, {0.01, 0.001, 0.0});
  Eigen::MatrixXd early = Eigen::MatrixXd::Zero(kRowsOfAll, 1), late = early;
  early.topRows(10).setOnes();
  late.bottomRows(10).setOnes();
  const Eigen::MatrixXd filled = Eigen::MatrixXd::Random(kRowsOfAll, 1);
  const auto white = [&](Eigen::MatrixXd column) {
    whitener.Apply(column);
    return column;
  };
  const Eigen::MatrixXd alone = white(early);
  EXPECT_LT((white(early + filled) - white(filled) - alone).norm(), 1e-9 * alone.norm());
  EXPECT_GT(alone.middleRows(2000, 100).norm(), 0.0);
  const Eigen::MatrixXd score = whitener.Scores(late).bias;
  EXPECT_LT((whitener.Scores(late + filled).bias - whitener.Scores(filled).bias - score).norm(),
            1e-9 * score.norm());
  EXPECT_GT(score.middleRows(2000, 100).norm(), 0.0);
}

}  // namespace
}  // namespace gyrobench::calibration
