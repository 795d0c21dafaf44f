#include "kinematics/geometry.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <random>

namespace gyrobench::kinematics {
namespace {

constexpr double kRad = std::numbers::pi / 180.0;

Matrix3 Times(const Matrix3& a, const Matrix3& b) {
  Matrix3 out = {};
  for (std::size_t i = 0; i < 3; ++i) {
    for (std::size_t j = 0; j < 3; ++j) {
      for (std::size_t k = 0; k < 3; ++k) out[i][j] += a[i][k] * b[k][j];
    }
  }
  return out;
}

Matrix3 Transposed(const Matrix3& a) {
  Matrix3 out = {};
  for (std::size_t i = 0; i < 3; ++i) {
    for (std::size_t j = 0; j < 3; ++j) out[i][j] = a[j][i];
  }
  return out;
}

Matrix3 About(int axis, double deg) {
  const double c = std::cos(deg * kRad), s = std::sin(deg * kRad);
  if (axis == 0) return {{{1, 0, 0}, {0, c, -s}, {0, s, c}}};
  return {{{c, -s, 0}, {s, c, 0}, {0, 0, 1}}};
}

std::mt19937& Random() {
  static std::mt19937 random(3);
  return random;
}

double Draw(double limit) {
  return std::uniform_real_distribution<double>(-limit, limit)(Random());
}

TEST(Geometry, OrientationIsTheProductOfTheThreeAxes) {
  for (int i = 0; i < 50; ++i) {
    const Vector3 a = {Draw(400), Draw(400), Draw(400)};
    const Matrix3 expected = Times(About(2, a[0]), Times(About(0, a[1]), About(2, a[2])));
    const Matrix3 r = StandOrientation(a);
    for (std::size_t row = 0; row < 3; ++row) {
      for (std::size_t column = 0; column < 3; ++column) {
        EXPECT_NEAR(r[row][column], expected[row][column], 1e-12);
      }
    }
  }
}

// R^T dR/dt = [w]x, by central differences of R alone.
TEST(Geometry, RatesAreTheDerivativeOfTheOrientation) {
  for (int i = 0; i < 50; ++i) {
    const Vector3 a = {Draw(180), Draw(180), Draw(180)}, rate = {Draw(40), Draw(40), Draw(40)};
    const double h = 1e-5;
    Vector3 later, earlier;
    for (std::size_t k = 0; k < 3; ++k) {
      later[k] = a[k] + h * rate[k];
      earlier[k] = a[k] - h * rate[k];
    }
    const Matrix3 up = StandOrientation(later), down = StandOrientation(earlier);
    Matrix3 derivative;
    for (std::size_t r = 0; r < 3; ++r) {
      for (std::size_t c = 0; c < 3; ++c)
        derivative[r][c] = (up[r][c] - down[r][c]) / (2 * h) / kRad;
    }
    const Matrix3 w = Times(Transposed(StandOrientation(a)), derivative);
    const Matrix3 j = StandRates(a);
    const std::array<double, 3> numeric = {w[2][1], w[0][2], w[1][0]};
    for (std::size_t c = 0; c < 3; ++c) {
      EXPECT_NEAR(j[c][0] * rate[0] + j[c][1] * rate[1] + j[c][2] * rate[2], numeric[c], 1e-6);
    }
  }
}

TEST(Geometry, EarthTurnsOnceADayAboutItsAxis) {
  for (const double heading : {0.0, 30.0, 200.0}) {
    const Vector3 w = EarthRate(52.0, heading);
    EXPECT_NEAR(std::hypot(w[0], w[1], w[2]) * 3600, 15.041, 1e-12);
    EXPECT_NEAR(std::asin(w[2] / std::hypot(w[0], w[1], w[2])) / kRad, 52.0, 1e-9);
  }
  // The horizontal part lies along x when x points north, along minus y when x points east.
  EXPECT_GT(EarthRate(0.0, 0.0)[0], 0.004);
  EXPECT_NEAR(EarthRate(0.0, 90.0)[0], 0.0, 1e-15);
  EXPECT_LT(EarthRate(0.0, 90.0)[1], -0.004);
}

TEST(Geometry, RotationBetweenOrientationsGivesBackTheTurn) {
  for (int i = 0; i < 50; ++i) {
    const double angle = Draw(170);
    Vector3 axis = {Draw(1), Draw(1), Draw(1)};
    const double norm = std::hypot(axis[0], axis[1], axis[2]);
    for (double& a : axis) a /= norm;
    std::array<double, 4> from = {Draw(1), Draw(1), Draw(1), Draw(1)};
    const double size =
        std::sqrt(from[0] * from[0] + from[1] * from[1] + from[2] * from[2] + from[3] * from[3]);
    for (double& f : from) f /= size;
    const double c = std::cos(0.5 * angle * kRad), s = std::sin(0.5 * angle * kRad);
    const std::array<double, 4> d = {c, s * axis[0], s * axis[1], s * axis[2]};
    // from (x) d, and its negative, which is the same orientation.
    std::array<double, 4> to = {from[0] * d[0] - from[1] * d[1] - from[2] * d[2] - from[3] * d[3],
                                from[0] * d[1] + from[1] * d[0] + from[2] * d[3] - from[3] * d[2],
                                from[0] * d[2] - from[1] * d[3] + from[2] * d[0] + from[3] * d[1],
                                from[0] * d[3] + from[1] * d[2] - from[2] * d[1] + from[3] * d[0]};
    if (i % 2 == 0) {
      for (double& t : to) t = -t;
    }
    const Vector3 v = RotationBetween(from, to);
    for (std::size_t k = 0; k < 3; ++k) EXPECT_NEAR(v[k], angle * axis[k], 1e-9);
  }
}

TEST(Geometry, QuaternionAndAnglesAgreeAboutTheVerticalAxis) {
  const double a = 37.0;
  const Matrix3 q = QuaternionOrientation({std::cos(a / 2 * kRad), 0, 0, std::sin(a / 2 * kRad)});
  const Matrix3 r = StandOrientation({a, 0, 0});
  for (std::size_t i = 0; i < 3; ++i) {
    for (std::size_t j = 0; j < 3; ++j) EXPECT_NEAR(q[i][j], r[i][j], 1e-14);
  }
  const Vector3 up = TransposedTimes(StandOrientation({10, 90, 0}), {0, 0, 1});
  EXPECT_NEAR(up[1], 1.0, 1e-14) << "with the middle axis at 90 deg the sensor's y axis points up";
}

}  // namespace
}  // namespace gyrobench::kinematics
