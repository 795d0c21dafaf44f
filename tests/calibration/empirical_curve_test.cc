#include "calibration/trace/empirical_curve.h"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <numeric>

#include "base/error.h"

namespace gyrobench::calibration {
namespace {

const std::vector<double> kKnots = {-3.0, -1.0, 0.5, 4.0, 5.0};
const std::vector<double> kValues = {1.0, -2.0, 0.25, 3.0, 2.0};

double At(double x) { return EmpiricalCurve(kKnots).Value(x, kValues); }

double SecondDerivative(const std::function<double(double)>& f, double x, double h) {
  return (f(x - h) - 2.0 * f(x) + f(x + h)) / (h * h);
}

TEST(EmpiricalCurve, PassesThroughItsValues) {
  for (std::size_t i = 0; i < kKnots.size(); ++i) EXPECT_NEAR(At(kKnots[i]), kValues[i], 1e-14);
}

TEST(EmpiricalCurve, IsAStraightLineThroughValuesOfOneAndOutsideTheKnotsInAnyCase) {
  std::vector<double> line;
  for (const double knot : kKnots) line.push_back(2.0 - 0.7 * knot);
  const EmpiricalCurve curve(kKnots);
  for (double x = -10.0; x < 10.0; x += 0.37)
    EXPECT_NEAR(curve.Value(x, line), 2.0 - 0.7 * x, 1e-12);
  for (const double x : {-20.0, 20.0}) EXPECT_NEAR(SecondDerivative(At, x, 1.0), 0.0, 1e-12);
}

// What makes a cubic spline natural: two continuous derivatives, the second 0 at both ends.
TEST(EmpiricalCurve, IsSmoothAcrossKnotsWithNoCurvatureAtItsEnds) {
  const double h = 1e-4;
  for (const double knot : kKnots) {
    const double below = (At(knot) - At(knot - h)) / h, above = (At(knot + h) - At(knot)) / h;
    EXPECT_NEAR(below, above, 1e-2);
    EXPECT_NEAR(SecondDerivative(At, knot - 2 * h, h), SecondDerivative(At, knot + 2 * h, h), 5e-2);
  }
  EXPECT_NEAR(SecondDerivative(At, kKnots.front(), h), 0.0, 1e-2);
  EXPECT_NEAR(SecondDerivative(At, kKnots.back(), h), 0.0, 1e-2);
}

TEST(EmpiricalCurve, WeightsGiveTheSameCurveAndSumToOne) {
  const EmpiricalCurve curve(kKnots);
  std::vector<double> weights(kKnots.size());
  for (double x = -6.0; x < 8.0; x += 0.31) {
    curve.Weights(x, weights.data());
    EXPECT_NEAR(std::accumulate(weights.begin(), weights.end(), 0.0), 1.0, 1e-12);
    EXPECT_NEAR(std::inner_product(weights.begin(), weights.end(), kValues.begin(), 0.0), At(x),
                1e-12);
  }
}

TEST(EmpiricalCurve, OfOneKnotIsAConstantAndOfTwoALine) {
  EXPECT_EQ(EmpiricalCurve({2.0}).Value(17.0, std::vector{4.0}), 4.0);
  EXPECT_NEAR(EmpiricalCurve({0.0, 2.0}).Value(3.0, std::vector{1.0, 2.0}), 2.5, 1e-14);
}

TEST(EmpiricalCurve, HandsANanOnAndRefusesKnotsThatDoNotGrow) {
  EXPECT_TRUE(std::isnan(At(std::nan(""))));
  EXPECT_THROW(EmpiricalCurve({}), DataError);
  EXPECT_THROW(EmpiricalCurve({1.0, 1.0}), DataError);
  EXPECT_THROW(EmpiricalCurve({1.0, std::nan("")}), DataError);
}

}  // namespace
}  // namespace gyrobench::calibration
