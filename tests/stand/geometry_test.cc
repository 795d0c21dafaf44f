// The stand's frames against rotation matrices multiplied out and differentiated numerically.
#include "stand/geometry.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <numbers>
#include <random>

namespace gyrobench::stand {
namespace {

constexpr double kRad = std::numbers::pi / 180.0;

Eigen::Matrix3d Turn(double deg, const Eigen::Vector3d& axis) {
  return Eigen::AngleAxisd(deg * kRad, axis).toRotationMatrix();
}
const Eigen::Vector3d kX = Eigen::Vector3d::UnitX();
const Eigen::Vector3d kY = Eigen::Vector3d::UnitY();
const Eigen::Vector3d kZ = Eigen::Vector3d::UnitZ();

Eigen::Matrix3d SensorToWorld(const Triple& a, const config::SiteScenario& s) {
  return Turn(s.tilt_x_deg, kX) * Turn(s.tilt_y_deg, kY) * Turn(a[0], kZ) *
         Turn(s.outer_middle_deg, kY) * Turn(a[1], kX) * Turn(s.middle_inner_deg, kY) *
         Turn(a[2], kZ) * Turn(s.mount_deg[2], kZ) * Turn(s.mount_deg[1], kY) *
         Turn(s.mount_deg[0], kX);
}

config::SiteScenario Crooked() {
  config::SiteScenario site;
  site.tilt_x_deg = 0.7;
  site.tilt_y_deg = -1.1;
  site.outer_middle_deg = 0.4;
  site.middle_inner_deg = -0.9;
  site.mount_deg = {1.5, -2.0, 30.0};
  return site;
}

void ExpectNear(const Triple& found, const Eigen::Vector3d& expected, double tolerance) {
  for (std::size_t i = 0; i < 3; ++i) {
    EXPECT_NEAR(found[i], expected[static_cast<Eigen::Index>(i)], tolerance);
  }
}

class GeometryTest : public testing::TestWithParam<bool> {
 protected:
  config::SiteScenario site_ = GetParam() ? Crooked() : config::SiteScenario{};
  Geometry geometry_{site_, 52.0, 30.0};
  std::mt19937_64 random_{7};
  Triple Random(double most) {
    std::uniform_real_distribution<double> uniform(-most, most);
    return {uniform(random_), uniform(random_), uniform(random_)};
  }
};

TEST_P(GeometryTest, RateIsTheDerivativeOfTheRotation) {
  for (int i = 0; i < 50; ++i) {
    const Triple angles = Random(180);
    const Triple rates = Random(60);
    geometry_.SetAngles(angles);
    const double dt = 1e-5;
    Triple later, earlier;
    for (std::size_t k = 0; k < 3; ++k) {
      later[k] = angles[k] + 0.5 * dt * rates[k];
      earlier[k] = angles[k] - 0.5 * dt * rates[k];
    }
    const Eigen::Matrix3d derivative =
        (SensorToWorld(later, site_) - SensorToWorld(earlier, site_)) / dt;
    const Eigen::Matrix3d skew = SensorToWorld(angles, site_).transpose() * derivative;
    const Eigen::Vector3d w_deg_s = Eigen::Vector3d(skew(2, 1), skew(0, 2), skew(1, 0)) / kRad;
    ExpectNear(geometry_.Rate(rates), w_deg_s, 1e-5);
  }
}

TEST_P(GeometryTest, GravityAndEarthRateAreTheWorldsVectorsInTheSensorsFrame) {
  const double w = 15.041 / 3600;
  const Eigen::Vector3d earth(w * std::cos(52 * kRad) * std::cos(30 * kRad),
                              -w * std::cos(52 * kRad) * std::sin(30 * kRad),
                              w * std::sin(52 * kRad));
  for (int i = 0; i < 50; ++i) {
    const Triple angles = Random(180);
    geometry_.SetAngles(angles);
    const Eigen::Matrix3d to_sensor = SensorToWorld(angles, site_).transpose();
    ExpectNear(geometry_.Gravity(), to_sensor * kZ, 1e-12);
    ExpectNear(geometry_.EarthRate(), to_sensor * earth, 1e-15);
  }
}

INSTANTIATE_TEST_SUITE_P(Stands, GeometryTest, testing::Values(false, true),
                         [](const auto& test) { return test.param ? "Crooked" : "Perfect"; });

TEST(Geometry, WithoutALatitudeTheEarthDoesNotTurn) {
  const Geometry geometry(config::SiteScenario{}, std::nullopt, 0.0);
  for (const double w : geometry.EarthRate()) EXPECT_EQ(w, 0.0);
}

TEST(Geometry, AtZeroAnglesTheAccelerometersZPointsUp) {
  const Geometry geometry(config::SiteScenario{}, 10.0, 0.0);
  EXPECT_EQ(geometry.Gravity(), (Triple{0, 0, 1}));
}

}  // namespace
}  // namespace gyrobench::stand
