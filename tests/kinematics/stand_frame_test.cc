#include "kinematics/stand_frame.h"

#include <gtest/gtest.h>

#include "tests/kinematics/turns.h"

namespace gyrobench::kinematics {
namespace {

void ExpectNear(const Matrix3& a, const Matrix3& b, double tolerance) {
  for (std::size_t i = 0; i < 3; ++i) {
    for (std::size_t j = 0; j < 3; ++j) EXPECT_NEAR(a[i][j], b[i][j], tolerance) << i << j;
  }
}

TEST(StandFrame, OrientationIsTheProductOfAxesLeansAndMounting) {
  Draws draw(2);
  for (int i = 0; i < 50; ++i) {
    const StandGeometry geometry = i % 2 == 0 ? StandGeometry{} : draw.Geometry(180, 10);
    const Vector3 angles_deg = draw.Angles(400);
    ExpectNear(StandFrame(geometry).Orientation(angles_deg), Product(geometry, angles_deg), 1e-12);
  }
}

TEST(StandFrame, RatesAreTheDerivativeOfTheOrientationHoweverTheStandLeans) {
  Draws draw(3);
  for (int i = 0; i < 50; ++i) {
    const StandGeometry geometry = i % 2 == 0 ? StandGeometry{} : draw.Geometry(180, 10);
    const Vector3 angles_deg = draw.Angles(180), rates_deg_s = draw.Angles(40);
    const Matrix3 j = StandFrame(geometry).Rates(angles_deg);
    const Vector3 numeric = NumericRate(geometry, angles_deg, rates_deg_s);
    for (std::size_t k = 0; k < 3; ++k) {
      EXPECT_NEAR(j[k][0] * rates_deg_s[0] + j[k][1] * rates_deg_s[1] + j[k][2] * rates_deg_s[2],
                  numeric[k], 1e-6);
    }
  }
}

TEST(StandFrame, NeighbouringAxesAreOffSquareByTheirLean) {
  const StandGeometry geometry = {.outer_middle_deg = 3.0, .middle_inner_deg = -2.0};
  for (const double middle_deg : {0.0, 40.0, 170.0}) {
    const Matrix3 j = Transposed(StandFrame(geometry).Rates({10.0, middle_deg, 20.0}));
    const auto dot = [](const Vector3& a, const Vector3& b) {
      return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
    };
    EXPECT_NEAR(std::abs(dot(j[0], j[1])), std::sin(3.0 * std::numbers::pi / 180), 1e-12);
    EXPECT_NEAR(std::abs(dot(j[1], j[2])), std::sin(2.0 * std::numbers::pi / 180), 1e-12);
  }
}

}  // namespace
}  // namespace gyrobench::kinematics
