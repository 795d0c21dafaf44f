// The reference's own uncertainty in what is measured against it.
#include "calibration/signal/reference_error.h"

#include <gtest/gtest.h>

#include <Eigen/LU>
#include <cmath>
#include <numbers>
#include <random>

#include "calibration/estimators/analyzer.h"
#include "calibration/sensor/make_vector.h"

namespace gyrobench::calibration {
namespace {

constexpr double kRadians = std::numbers::pi / 180.0;

TEST(ReferenceError, IsTheQuadratureSumOfWhatIsSaid) {
  ReferenceUncertainty said;
  EXPECT_FALSE(MakeReferenceError(said, {90, 90, 90}).said);
  said.scale = 3e-4;
  said.eccentricity_deg = 0.02;
  said.alignment_deg = 1.0;
  const ReferenceError error = MakeReferenceError(said, {9.0, 180.0, 3600.0});
  ASSERT_TRUE(error.said);
  const double tilt = std::pow(1.0 * kRadians, 2) / (2.0 * std::sqrt(5.0));
  // Amplitude uniform up to 0.02 deg, any phase; chord over turn.
  const auto wave = [](double chord, double turn_deg) {
    return 0.02 / std::sqrt(3.0) / std::sqrt(2.0) * chord / turn_deg;
  };
  EXPECT_NEAR(error.OfScale(0), std::hypot(3e-4, wave(2.0 * std::sin(4.5 * kRadians), 9.0), tilt),
              1e-12);
  EXPECT_NEAR(error.OfScale(1), std::hypot(3e-4, wave(2.0, 180.0), tilt), 1e-12);
  EXPECT_NEAR(error.OfScale(2), std::hypot(3e-4, wave(2.0, 3600.0), tilt), 1e-12);
}

// The formula for the tilt: a turn is seen as cos(theta) of itself, theta uniform up to its bound.
TEST(ReferenceError, OfAlignmentIsTheRmsOfWhatATiltTakesOff) {
  std::mt19937_64 random(1);
  std::uniform_real_distribution<double> theta(0.0, 2.0 * kRadians);
  double square = 0.0;
  constexpr int kDraws = 200'000;
  for (int i = 0; i < kDraws; ++i) square += std::pow(1.0 - std::cos(theta(random)), 2);
  ReferenceUncertainty said;
  said.alignment_deg = 2.0;
  EXPECT_NEAR(MakeReferenceError(said, {}).own[0], std::sqrt(square / kDraws), 0.02 * 6e-4);
}

Eigen::Matrix3d Matrix() {
  Eigen::Matrix3d m;
  m << 1.01, 0.03, -0.02, 0.01, 0.98, 0.05, -0.04, 0.02, 1.03;
  return m;
}

// A channel's row of M with an error of the fit.
ChannelRow RowOf(std::size_t c, double sigma, const ReferenceError& error) {
  ChannelRow row;
  row.channel = c;
  row.fitted = true;
  row.units_per_deg_s = 131.0;
  row.values = Matrix().row(static_cast<Eigen::Index>(c)).transpose();
  row.covariance = sigma * sigma * Eigen::Matrix3d::Identity();
  row.reference = error;
  return row;
}

// 4000 benches, each with a reference and a fit of its own: how far M and A are from the truth,
// against what is stated. The sample deviation of 4000 draws is within 5 % of its expectation in
// all but one of 10^5 cases (4.5 of its standard errors of 1.1 %).
TEST(ReferenceError, GoesThroughTheMatrixIntoItsInverseAsDrawnBenchesShow) {
  ReferenceUncertainty said;
  said.scale = 2e-3;
  said.eccentricity_deg = 0.2;
  said.alignment_deg = 0.3;
  const ReferenceError error = MakeReferenceError(said, {30.0, 90.0, 360.0});
  constexpr double kFit = 5e-4;
  constexpr int kDraws = 4000;
  const ChannelRow rows[] = {RowOf(0, kFit, error), RowOf(1, kFit, error), RowOf(2, kFit, error)};
  const VectorCalibration stated = JoinChannels(rows);
  ASSERT_TRUE(stated.matrix);
  std::mt19937_64 random(11);
  std::normal_distribution<double> normal;
  Eigen::Matrix3d m_square = Eigen::Matrix3d::Zero(), a_square = m_square;
  const Eigen::Matrix3d a = Matrix().inverse() / 131.0;
  for (int draw = 0; draw < kDraws; ++draw) {
    Eigen::Matrix3d e = error.common * normal(random) * Eigen::Matrix3d::Identity();
    Eigen::Matrix3d fit;
    for (Eigen::Index i = 0; i < 3; ++i) {
      for (Eigen::Index j = 0; j < 3; ++j) {
        e(i, j) +=
            (i == j ? error.own[static_cast<std::size_t>(j)] : error.across) * normal(random);
        fit(i, j) = kFit * normal(random);
      }
    }
    const Eigen::Matrix3d m_est = Matrix() * (Eigen::Matrix3d::Identity() + e) + fit;
    m_square += (m_est - Matrix()).cwiseAbs2();
    a_square += (m_est.inverse() / 131.0 - a).cwiseAbs2();
  }
  for (std::size_t i = 0; i < 3; ++i) {
    for (std::size_t j = 0; j < 3; ++j) {
      const auto row = static_cast<Eigen::Index>(i), column = static_cast<Eigen::Index>(j);
      const double m_rms = std::sqrt(m_square(row, column) / kDraws);
      const double a_rms = std::sqrt(a_square(row, column) / kDraws);
      EXPECT_NEAR(stated.matrix->m_std_error[i][j] / m_rms, 1.0, 0.05) << i << j;
      EXPECT_NEAR(stated.matrix->a_std_error[i][j] / a_rms, 1.0, 0.05) << i << j;
      EXPECT_NEAR(stated.matrix->m_statistical_std_error[i][j], kFit, 1e-12);
      EXPECT_LT(stated.matrix->a_statistical_std_error[i][j], stated.matrix->a_std_error[i][j]);
    }
  }
}

TEST(ReferenceError, ThatIsNotSaidAddsNothing) {
  const ChannelRow rows[] = {RowOf(0, 1e-3, {}), RowOf(1, 1e-3, {}), RowOf(2, 1e-3, {})};
  const VectorCalibration stated = JoinChannels(rows);
  EXPECT_EQ(stated.matrix->m_std_error, stated.matrix->m_statistical_std_error);
  EXPECT_EQ(stated.matrix->a_std_error, stated.matrix->a_statistical_std_error);
}

}  // namespace
}  // namespace gyrobench::calibration
