#include "calibration/effects/empirical_curve.h"

#include <gtest/gtest.h>

#include <cmath>

#include "base/error.h"

namespace gyrobench::calibration {
namespace {

const std::vector<double> kKnots = {-3.0, -1.0, 0.5, 4.0, 5.0};
const std::vector<double> kValues = {1.0, -2.0, 0.25, 3.0, 2.0};

double At(double x) { return EmpiricalCurve(kKnots).Value(x, kValues); }

TEST(EmpiricalCurve, PassesThroughItsValues) {
  for (std::size_t i = 0; i < kKnots.size(); ++i) EXPECT_NEAR(At(kKnots[i]), kValues[i], 1e-14);
}

TEST(EmpiricalCurve, IsStraightBetweenKnotsAndConstantOutside) {
  for (std::size_t i = 0; i + 1 < kKnots.size(); ++i) {
    const double middle = 0.5 * (kKnots[i] + kKnots[i + 1]);
    EXPECT_NEAR(At(middle), 0.5 * (kValues[i] + kValues[i + 1]), 1e-14);
  }
  EXPECT_EQ(At(-1e6), kValues.front());
  EXPECT_EQ(At(1e6), kValues.back());
}

TEST(EmpiricalCurve, OfOneKnotIsAConstantAndOfTwoAStepBetweenConstants) {
  const EmpiricalCurve constant({2.0});
  EXPECT_EQ(constant.Value(17.0, std::vector{4.0}), 4.0);
  EXPECT_TRUE(std::isnan(constant.Value(std::nan(""), std::vector{4.0})));
  const EmpiricalCurve step({0.0, 2.0});
  EXPECT_EQ(step.Value(-1.0, std::vector{1.0, 2.0}), 1.0);
  EXPECT_EQ(step.Value(3.0, std::vector{1.0, 2.0}), 2.0);
}

TEST(EmpiricalCurve, HandsANanOnAndRefusesKnotsThatDoNotGrow) {
  EXPECT_TRUE(std::isnan(At(std::nan(""))));
  EXPECT_THROW(EmpiricalCurve({}), DataError);
  EXPECT_THROW(EmpiricalCurve({1.0, 1.0}), DataError);
  EXPECT_THROW(EmpiricalCurve({1.0, std::nan("")}), DataError);
}

}  // namespace
}  // namespace gyrobench::calibration
