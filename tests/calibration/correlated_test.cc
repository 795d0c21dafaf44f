#include <gtest/gtest.h>

#include <Eigen/QR>
#include <cmath>
#include <random>
#include <utility>
#include <vector>

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

// Rows that were measured again and again, each time with the same error, and the same in the
// column.
class Repeated {
 public:
  Repeated(unsigned seed, Eigen::Index times) : noise_(seed) {
    const Eigen::Index places = kRows / times;
    for (Eigen::Index i = 0; i < kRows; ++i) place.push_back(static_cast<std::size_t>(i % places));
  }
  Eigen::VectorXd Draw() {
    const Eigen::VectorXd once = noise_.Draw(0.0);
    return once(place);
  }
  Eigen::VectorXd DrawAnew() { return noise_.Draw(0.0); }
  // 0 but at the first `places` of them, where it is what it was.
  Eigen::VectorXd AtFirst(Eigen::VectorXd values, std::size_t places) const {
    for (Eigen::Index i = 0; i < kRows; ++i)
      if (place[static_cast<std::size_t>(i)] >= places) values(i) = 0.0;
    return values;
  }

  std::vector<std::size_t> place;

 private:
  CorrelatedNoise noise_;
};

// How often a column that has no part in the output is beyond one in twenty, where it acts at so
// many places.
Rates FalseRatesWhereRepeated(Eigen::Index times, std::size_t places, bool errors_too) {
  Rates rates;
  for (unsigned seed = 0; seed < kRepetitions; ++seed) {
    Repeated repeated(seed, times);
    const Eigen::VectorXd column = repeated.AtFirst(repeated.Draw(), places);
    const Eigen::VectorXd output = errors_too ? repeated.Draw() : repeated.DrawAnew();
    const Fitted fit = Fit(column, output);
    const double gain = GainWhereClustered(column, output, fit.residual, repeated.place).gain;
    rates.white += fit.gain_if_white > kOneInTwenty;
    rates.correlated += gain > kOneInTwenty;
  }
  rates.white /= kRepetitions;
  rates.correlated /= kRepetitions;
  return rates;
}

// One in twenty, and four standard deviations of a share of 600.
constexpr double kAboutOneInTwenty = 0.086;

TEST(Clustered, KeepsTheOddsWhereErrorsComeAgain) {
  for (const Eigen::Index times : {3, 20}) {
    const Rates rates = FalseRatesWhereRepeated(times, kRows, true);
    EXPECT_GT(rates.white, 0.15) << times;
    EXPECT_LT(rates.correlated, kAboutOneInTwenty) << times;
  }
}

// Of few places the errors' size is known badly: then a false find is up to three times as
// likely as it says.
TEST(Clustered, NearlyKeepsTheOddsAtFewPlaces) {
  const std::vector<std::pair<std::size_t, double>> odds = {{6, 0.16}, {12, 0.12}};
  for (const auto& [places, most] : odds) {
    const Rates rates = FalseRatesWhereRepeated(20, places, true);
    EXPECT_GT(rates.white, 0.5) << places;
    EXPECT_LT(rates.correlated, most) << places;
  }
}

TEST(Clustered, AsksNoMoreWhereErrorsAreNew) {
  EXPECT_NEAR(FalseRatesWhereRepeated(20, kRows, false).correlated, 0.05, 0.036);
}

// A column at one place, or at two with two columns: nothing is left to know the errors by.
TEST(Clustered, IsWhiteWhereNoFreedomIsLeft) {
  Repeated repeated(2, 20);
  const Eigen::VectorXd column = repeated.AtFirst(repeated.Draw(), 1);
  const Eigen::VectorXd output = repeated.Draw();
  const Fitted fit = Fit(column, output);
  EXPECT_NEAR(GainWhereClustered(column, output, fit.residual, repeated.place).gain,
              fit.gain_if_white, 1e-9 * fit.gain_if_white);
  EXPECT_EQ(
      GainWhereClustered(column, Eigen::VectorXd::Zero(kRows), fit.residual, repeated.place).gain,
      0.0);
}

// What acts once, as a step, is known by no fewer rows for those that share their places.
TEST(Clustered, LeavesWhatActsOnce) {
  Repeated repeated(1, 20);
  Eigen::VectorXd column = Eigen::VectorXd::Zero(kRows);
  column.segment(130, 3).setOnes();
  const Eigen::VectorXd output = 3.0 * column + repeated.DrawAnew();
  const Fitted fit = Fit(column, output);
  EXPECT_NEAR(GainWhereClustered(column, output, fit.residual, repeated.place).gain,
              fit.gain_if_white, 1e-9 * fit.gain_if_white);
}

TEST(Clustered, DependsOnTheSpanOfTheColumnsOnly) {
  Repeated repeated(3, 20);
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
