#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <random>
#include <vector>

#include "kinematics/rotations.h"
#include "kinematics/stand_frame.h"

namespace gyrobench::kinematics {
namespace {

constexpr double kRad = std::numbers::pi / 180.0;

std::mt19937& Random() {
  static std::mt19937 random(3);
  return random;
}

double Draw(double limit) {
  return std::uniform_real_distribution<double>(-limit, limit)(Random());
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

TEST(MountAngles, GiveTheRotationBack) {
  const double right = 90.0;
  std::vector<Vector3> mounts = {{10.0, right, 30.0}, {10.0, -right, 30.0}, {180.0, 0.0, -180.0}};
  for (int i = 0; i < 50; ++i) mounts.push_back({Draw(180.0), Draw(right), Draw(180.0)});
  for (const Vector3& deg : mounts) {
    const Eigen::Matrix3d mount = FixedRotations({.mount_deg = deg}).mount;
    const Eigen::Vector3d angles = MountAngles_rad(mount) / kRad;
    const Eigen::Matrix3d again =
        FixedRotations({.mount_deg = {angles[0], angles[1], angles[2]}}).mount;
    EXPECT_LT((again - mount).cwiseAbs().maxCoeff(), 1e-7)
        << deg[0] << " " << deg[1] << " " << deg[2];
    EXPECT_LE(std::fabs(angles[1]), right + 1e-9);
  }
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
  const Matrix3 r = StandFrame().Orientation({a, 0, 0});
  for (std::size_t i = 0; i < 3; ++i) {
    for (std::size_t j = 0; j < 3; ++j) EXPECT_NEAR(q[i][j], r[i][j], 1e-14);
  }
  const Vector3 up = TransposedTimes(StandFrame().Orientation({10, 90, 0}), {0, 0, 1});
  EXPECT_NEAR(up[1], 1.0, 1e-14) << "with the middle axis at 90 deg the sensor's y axis points up";
}

}  // namespace
}  // namespace gyrobench::kinematics
