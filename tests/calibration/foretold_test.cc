// The chance of held-out rows by a fit, against the normal density with its covariance written out.
#include "calibration/gls/foretold.h"

#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <random>
#include <vector>

namespace gyrobench::testing {
namespace {

using calibration::HeldOutRows;
using calibration::LogForetold;

Eigen::MatrixXd Drawn(Eigen::Index rows, Eigen::Index columns, unsigned seed) {
  std::mt19937_64 random(seed);
  std::normal_distribution<double> normal;
  return Eigen::MatrixXd::NullaryExpr(rows, columns, [&] { return normal(random); });
}

HeldOutRows RowsOf(const Eigen::MatrixXd& columns, const Eigen::VectorXd& residual) {
  return {columns.transpose() * columns, columns.transpose() * residual, residual.squaredNorm()};
}

// Twice the logarithm of the density of N(0, I + W information^-1 W'), without its 2 pi.
double ByCovariance(const Eigen::MatrixXd& information, const Eigen::MatrixXd& columns,
                    const Eigen::VectorXd& residual) {
  const Eigen::MatrixXd covariance = Eigen::MatrixXd::Identity(columns.rows(), columns.rows()) +
                                     columns * information.inverse() * columns.transpose();
  const Eigen::LLT<Eigen::MatrixXd> factor(covariance);
  const Eigen::MatrixXd root = factor.matrixL();
  return -residual.dot(factor.solve(residual)) - 2.0 * root.diagonal().array().log().sum();
}

TEST(HeldOutRowsAsForetold, HaveTheDensityOfTheirOwnNoiseAndOfWhatTheFitLeftOpen) {
  for (unsigned seed = 1; seed <= 20; ++seed) {
    const Eigen::MatrixXd seen = Drawn(30, 4, seed), columns = Drawn(7, 4, seed + 100);
    const Eigen::MatrixXd training = seen.transpose() * seen;
    const Eigen::VectorXd residual = Drawn(7, 1, seed + 200);
    EXPECT_NEAR(LogForetold(training, RowsOf(columns, residual), {}),
                ByCovariance(training, columns, residual), 1e-9);
  }
}

// The difference between two models is what counts; of a column that training has not seen the
// prior is wide, and how wide is the same in both.
TEST(HeldOutRowsAsForetold, CountAColumnOfTheirOwnAsOneOfWhichNothingWasKnown) {
  constexpr double kNextToNothing = 1e-9;
  const Eigen::MatrixXd seen = Drawn(30, 3, 1), columns = Drawn(7, 4, 2);
  const Eigen::VectorXd residual = Drawn(7, 1, 3);
  Eigen::MatrixXd training = Eigen::MatrixXd::Zero(4, 4);
  training.topLeftCorner(3, 3) = seen.transpose() * seen;
  Eigen::MatrixXd wide = training;
  wide(3, 3) = kNextToNothing;
  const auto by_covariance = [&](Eigen::Index first) {
    const Eigen::Index count = 4 - first;
    return ByCovariance(wide.bottomRightCorner(count, count), columns.rightCols(count), residual);
  };
  const auto foretold = [&](Eigen::Index first) {
    const Eigen::Index count = 4 - first;
    return LogForetold(training.bottomRightCorner(count, count),
                       RowsOf(columns.rightCols(count), residual), {count - 1});
  };
  EXPECT_NEAR(foretold(0) - foretold(1), by_covariance(0) - by_covariance(1), 1e-5);
}

TEST(HeldOutRowsAsForetold, DoNotDependOnUnits) {
  const Eigen::MatrixXd seen = Drawn(30, 3, 4), columns = Drawn(7, 3, 5);
  const Eigen::VectorXd residual = Drawn(7, 1, 6);
  const Eigen::Vector3d units(1e-6, 1.0, 1e5);
  const auto in = [&](const Eigen::Vector3d& unit) {
    const Eigen::MatrixXd scaled = seen * unit.asDiagonal();
    return LogForetold(scaled.transpose() * scaled, RowsOf(columns * unit.asDiagonal(), residual),
                       {2});
  };
  EXPECT_NEAR(in(units), in(Eigen::Vector3d::Ones()), 1e-8);
}

// A motion that no other row had is foretold badly by a coefficient that is hardly known; that it
// is hardly known was foretold as well.
TEST(HeldOutRowsAsForetold, ForgiveAnErrorThatTheFitSaidItMightMake) {
  Eigen::MatrixXd far(1, 1), training(1, 1);
  far << 30.0;
  training << 1.0;
  const Eigen::VectorXd error = Eigen::VectorXd::Constant(1, 20.0);  // of a coefficient 0.7 off
  Eigen::MatrixXd sure(1, 1);
  sure << 1e6;
  EXPECT_GT(LogForetold(training, RowsOf(far, error), {}),
            LogForetold(sure, RowsOf(far, error), {}) + 100.0);
}

}  // namespace
}  // namespace gyrobench::testing
