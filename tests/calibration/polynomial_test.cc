#include "calibration/gls/polynomial.h"

#include <gtest/gtest.h>

#include <cmath>

namespace gyrobench::calibration {
namespace {

// The same curve in both bases, at every temperature.
TEST(Polynomial, KeepsItsValuesWhenTheVariableChanges) {
  const TemperatureScale scale{30.5, 7.5};
  const std::vector<double> a = {1.0, -0.5, 0.25, 2.0, -1.5, 0.75};
  const std::vector<double> c = Transformed(ToPowersOf(scale, 27.3, 6), a);
  for (double t = 20; t <= 45; t += 0.7) {
    EXPECT_NEAR(Evaluate(c, t - 27.3), Evaluate(a, scale.u(t)),
                1e-9 * (1 + std::abs(Evaluate(a, scale.u(t)))));
  }
}

// The variance of the curve does not depend on the basis.
TEST(Polynomial, KeepsItsVarianceWhenTheVariableChanges) {
  const TemperatureScale scale{30.0, 8.0};
  const std::vector<double> covariance = {2.0, 0.3, 0.1, 0.3, 1.0, -0.2, 0.1, -0.2, 0.5};
  const std::vector<double> moved =
      TransformedCovariance(ToPowersOf(scale, 25.0, 3), covariance, 3);
  for (double t = 22; t <= 38; t += 1.3) {
    auto variance = [](const std::vector<double>& c, double x) {
      double sum = 0;
      for (std::size_t i = 0; i < 3; ++i) {
        for (std::size_t j = 0; j < 3; ++j)
          sum += c[i * 3 + j] * std::pow(x, static_cast<double>(i + j));
      }
      return sum;
    };
    EXPECT_NEAR(variance(moved, t - 25.0), variance(covariance, scale.u(t)), 1e-9);
  }
}

TEST(Polynomial, PassesThroughPointsThatLieOnOne) {
  std::vector<double> u, y;
  for (int i = 0; i < 20; ++i) {
    u.push_back(-1 + 0.1 * i);
    y.push_back(3 - u.back() + 2 * u.back() * u.back());
  }
  const PolynomialFit fit = FitPolynomial(u, y, 3);
  EXPECT_NEAR(fit.residual_square, 0.0, 1e-20);
  EXPECT_NEAR(fit.coefficients[2], 2.0, 1e-10);
  EXPECT_NEAR(fit.coefficients[3], 0.0, 1e-10);
}

}  // namespace
}  // namespace gyrobench::calibration
