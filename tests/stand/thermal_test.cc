#include "stand/thermal.h"

#include <gtest/gtest.h>

#include <cmath>

namespace gyrobench::stand {
namespace {

struct Fixture {
  config::ThermalScenario thermal;
  config::RoomScenario room;
};

TEST(Thermal, WarmsUpFromTheColdAlongOneExponential) {
  Fixture f;
  f.thermal.start_degC = -10.0;
  Thermal thermal(f.thermal, f.room);
  for (int i = 1; i <= 5000; ++i) {
    const double t = 0.2 * i;
    thermal.Advance(t);
    const double expected = 38.0 - 48.0 * std::exp(-t / 250.0);
    ASSERT_NEAR(thermal.package_degC(), expected, 1e-9);
    ASSERT_NEAR(thermal.die_rate_degC_s(), 48.0 / 250.0 * std::exp(-(t - 0.1) / 250.0), 1e-5);
  }
}

TEST(Thermal, DoesNotDependOnTheStepsTaken) {
  Fixture f;
  f.thermal.start_degC = 0.0;
  Thermal coarse(f.thermal, f.room);
  Thermal fine(f.thermal, f.room);
  for (int i = 1; i <= 1000; ++i) fine.Advance(0.1 * i);
  for (int i = 1; i <= 10; ++i) coarse.Advance(10.0 * i);
  EXPECT_NEAR(coarse.package_degC(), fine.package_degC(), 1e-9);
}

TEST(Thermal, WithoutAStartTemperatureItBeginsAtTheRooms) {
  Fixture f;
  f.room.temperature_degC = 19.0;
  EXPECT_EQ(Thermal(f.thermal, f.room).package_degC(), 19.0);
}

TEST(Thermal, AFanPullsItDownAndAfterwardsItComesBack) {
  Fixture f;
  f.thermal.start_degC = 38.0;
  f.room.fans = {{.at_s = 100, .duration_s = 1000}};
  Thermal thermal(f.thermal, f.room);
  thermal.Advance(99);
  EXPECT_NEAR(thermal.package_degC(), 38.0, 1e-9);
  for (int t = 100; t < 1100; ++t) thermal.Advance(t);
  EXPECT_NEAR(thermal.package_degC(), 27.0, 0.01);
  for (int t = 1100; t < 4000; ++t) thermal.Advance(t);
  EXPECT_NEAR(thermal.package_degC(), 38.0, 0.01);
}

TEST(Thermal, AFanSwitchedByHandPullsItDownUntilItIsSwitchedOff) {
  Fixture f;
  f.thermal.start_degC = 38.0;
  Thermal thermal(f.thermal, f.room);
  thermal.SetFan(true);
  for (int t = 1; t < 1100; ++t) thermal.Advance(t);
  EXPECT_NEAR(thermal.package_degC(), 27.0, 0.01);
  thermal.SetFan(false);
  for (int t = 1100; t < 4000; ++t) thermal.Advance(t);
  EXPECT_NEAR(thermal.package_degC(), 38.0, 0.01);
}

TEST(Thermal, SomeoneWhoCoolsTheUnitSetsItsTemperatureAtThatTime) {
  Fixture f;
  f.thermal.chills = {{.at_s = 50, .to_degC = -12}};
  Thermal thermal(f.thermal, f.room);
  thermal.Advance(49.9);
  EXPECT_GT(thermal.package_degC(), 20.0);
  thermal.Advance(50.0);
  EXPECT_EQ(thermal.package_degC(), -12.0);
  EXPECT_EQ(thermal.die_degC(), -12.0);
}

TEST(Thermal, TheElementFollowsTheThermometerWithItsLag) {
  Fixture f;
  f.thermal.die_lag_s = 5.0;
  f.thermal.start_degC = 0.0;
  Thermal thermal(f.thermal, f.room);
  for (int i = 1; i <= 6000; ++i) thermal.Advance(0.01 * i);
  const double rate = 38.0 / 250.0 * std::exp(-60.0 / 250.0);
  EXPECT_NEAR(thermal.package_degC() - thermal.die_degC(), 5.0 * rate, 0.03 * 5.0 * rate);
}

TEST(Thermal, TheRoomDriftsAndSwings) {
  Fixture f;
  f.room.drift_degC_per_h = 2.0;
  f.room.swing_degC = 1.5;
  f.room.swing_period_s = 400;
  const Thermal thermal(f.thermal, f.room);
  EXPECT_NEAR(thermal.Room(3600), 24.0, 1e-9);
  EXPECT_NEAR(thermal.Room(100), 22.0 + 2.0 / 36.0 + 1.5, 1e-9);
}

}  // namespace
}  // namespace gyrobench::stand
