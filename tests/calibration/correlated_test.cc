#include <gtest/gtest.h>

#include <Eigen/QR>
#include <cmath>
#include <random>

#include "calibration/gls/robust_gain.h"

namespace gyrobench::calibration {
namespace {

constexpr Eigen::Index kRows = 1000, kBlock = 4;
constexpr int kRepetitions = 600;
// Of chi square of one degree: one in twenty is beyond.
constexpr double kOneInTwenty = 3.841;

class CorrelatedNoise {
 public:
  explicit CorrelatedNoise(unsigned seed) : random_(seed) {}

  // Each value holds `memory` of the one before; variance 1.
  Eigen::VectorXd Draw(double memory) {
    Eigen::VectorXd v(kRows);
    double value = normal_(random_);
    for (double& x : v) {
      x = value;
      value = memory * value + std::sqrt(1.0 - memory * memory) * normal_(random_);
    }
    return v;
  }

 private:
  std::mt19937 random_;
  std::normal_distribution<double> normal_;
};

struct Fitted {
  Eigen::VectorXd residual;
  double gain_if_white = 0.0;
};

Fitted Fit(const Eigen::MatrixXd& columns, const Eigen::VectorXd& output) {
  const Eigen::VectorXd values = columns.colPivHouseholderQr().solve(output);
  const Eigen::VectorXd explained = columns * values;
  return {output - explained, explained.squaredNorm()};
}

// How often a column that has no part in the output is beyond one in twenty.
struct Rates {
  double white = 0.0, correlated = 0.0;
};
Rates FalseRates(double memory_of_column, double memory_of_output) {
  Rates rates;
  for (int seed = 0; seed < kRepetitions; ++seed) {
    CorrelatedNoise noise(static_cast<unsigned>(seed));
    const Eigen::VectorXd column = noise.Draw(memory_of_column);
    const Eigen::VectorXd output = noise.Draw(memory_of_output);
    const Fitted fit = Fit(column, output);
    const double gain = GainWhereCorrelated(column, output, fit.residual, {0}, kBlock).gain;
    rates.white += fit.gain_if_white > kOneInTwenty;
    rates.correlated += gain > kOneInTwenty;
  }
  rates.white /= kRepetitions;
  rates.correlated /= kRepetitions;
  return rates;
}

TEST(Correlated, KeepsTheOddsWhereASlowColumnMeetsASlowResidual) {
  const Rates rates = FalseRates(0.9, 0.8);
  EXPECT_GT(rates.white, 0.25);
  // 0.05, four standard deviations of a share of 600, and what ten blocks of 250 leave uncertain.
  EXPECT_LT(rates.correlated, 0.12);
}

TEST(Correlated, AsksNoMoreOfAWhiteResidual) {
  const Rates rates = FalseRates(0.9, 0.0);
  EXPECT_NEAR(rates.correlated, 0.05, 0.036);
}

TEST(Correlated, NeverGainsMoreThanBesideAWhiteResidual) {
  for (unsigned seed = 0; seed < 50; ++seed) {
    CorrelatedNoise noise(seed);
    const Eigen::VectorXd column = noise.Draw(0.9);
    // Neighbours differ: errors that allow for it are smaller.
    const Eigen::VectorXd output = noise.Draw(-0.8) + column;
    const Fitted fit = Fit(column, output);
    EXPECT_LE(GainWhereCorrelated(column, output, fit.residual, {0}, kBlock).gain,
              fit.gain_if_white * (1.0 + 1e-9));
  }
}

TEST(Correlated, DependsOnTheSpanOfTheColumnsOnly) {
  CorrelatedNoise noise(1);
  Eigen::MatrixXd columns(kRows, 2);
  columns << noise.Draw(0.9), noise.Draw(0.5);
  const Eigen::VectorXd output = noise.Draw(0.8) + 0.2 * columns.col(0);
  const Fitted fit = Fit(columns, output);
  Eigen::MatrixXd mixed(kRows, 3);
  mixed << 1e4 * columns.col(0) - 3e3 * columns.col(1), 1e-5 * columns.col(1),
      Eigen::VectorXd::Zero(kRows);
  const std::vector<Eigen::Index> runs = {0, 300};
  const CorrelatedGain plain = GainWhereCorrelated(columns, output, fit.residual, runs, kBlock);
  const CorrelatedGain other = GainWhereCorrelated(mixed, output, fit.residual, runs, kBlock);
  EXPECT_NEAR(other.gain, plain.gain, 1e-6 * plain.gain);
  EXPECT_EQ(plain.rank, 2);
  EXPECT_EQ(other.rank, 2);
}

// The end of one run says nothing of the begin of the next: another sign of one run's columns and
// output together changes nothing, though products across the boundary change their sign.
TEST(Correlated, KnowsWhereARunEnds) {
  CorrelatedNoise noise(2);
  Eigen::VectorXd column = noise.Draw(0.95), output = noise.Draw(0.9);
  const std::vector<Eigen::Index> runs = {0, 398};
  auto gain = [&](const std::vector<Eigen::Index>& begins) {
    return GainWhereCorrelated(column, output, Fit(column, output).residual, begins, kBlock).gain;
  };
  const double before = gain(runs), joined = gain({0});
  EXPECT_GT(std::fabs(joined - before), 1e-6 * before);
  column.tail(602) *= -1.0;
  output.tail(602) *= -1.0;
  EXPECT_NEAR(gain(runs), before, 1e-9 * before);
}

// Rows that were measured again and again, with the same error each time and the same in the column.
class Repeated {
 public:
  static constexpr Eigen::Index kTimes = 20, kPlaces = kRows / kTimes;

  explicit Repeated(unsigned seed) : noise_(seed) {
    for (Eigen::Index i = 0; i < kRows; ++i) place.push_back(static_cast<std::size_t>(i % kPlaces));
  }
  Eigen::VectorXd Draw() {
    const Eigen::VectorXd once = noise_.Draw(0.0);
    return once(place);
  }
  Eigen::VectorXd DrawAnew() { return noise_.Draw(0.0); }

  std::vector<std::size_t> place;

 private:
  CorrelatedNoise noise_;
};

TEST(Clustered, KeepsTheOddsWhereErrorsComeAgain) {
  double white = 0.0, clustered = 0.0;
  for (unsigned seed = 0; seed < kRepetitions; ++seed) {
    Repeated repeated(seed);
    const Eigen::VectorXd column = repeated.Draw(), output = repeated.Draw();
    const Fitted fit = Fit(column, output);
    white += fit.gain_if_white > kOneInTwenty;
    clustered +=
        GainWhereClustered(column, output, fit.residual, repeated.place).gain > kOneInTwenty;
  }
  EXPECT_GT(white / kRepetitions, 0.5);
  // 0.05, and four standard deviations of a share of 600.
  EXPECT_LT(clustered / kRepetitions, 0.086);
}

TEST(Clustered, AsksNoMoreWhereErrorsAreNew) {
  double clustered = 0.0;
  for (unsigned seed = 0; seed < kRepetitions; ++seed) {
    Repeated repeated(seed);
    const Eigen::VectorXd column = repeated.Draw(), output = repeated.DrawAnew();
    const Fitted fit = Fit(column, output);
    clustered +=
        GainWhereClustered(column, output, fit.residual, repeated.place).gain > kOneInTwenty;
  }
  EXPECT_NEAR(clustered / kRepetitions, 0.05, 0.036);
}

// What acts once, as a step, is known by no fewer rows for those that share their places.
TEST(Clustered, LeavesWhatActsOnce) {
  Repeated repeated(1);
  Eigen::VectorXd column = Eigen::VectorXd::Zero(kRows);
  column.segment(130, 3).setOnes();
  const Eigen::VectorXd output = 3.0 * column + repeated.DrawAnew();
  const Fitted fit = Fit(column, output);
  EXPECT_NEAR(GainWhereClustered(column, output, fit.residual, repeated.place).gain,
              fit.gain_if_white, 1e-9 * fit.gain_if_white);
}

TEST(Clustered, DependsOnTheSpanOfTheColumnsOnly) {
  Repeated repeated(3);
  Eigen::MatrixXd columns(kRows, 2), mixed(kRows, 2);
  columns << repeated.Draw(), repeated.Draw();
  mixed << 1e4 * columns.col(0) - 3e3 * columns.col(1), 1e-5 * columns.col(1);
  const Eigen::VectorXd output = repeated.Draw();
  const Eigen::VectorXd residual = Fit(columns, output).residual;
  const double plain = GainWhereClustered(columns, output, residual, repeated.place).gain;
  EXPECT_NEAR(GainWhereClustered(mixed, output, residual, repeated.place).gain, plain,
              1e-6 * plain);
}

}  // namespace
}  // namespace gyrobench::calibration
