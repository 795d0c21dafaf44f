// The fakes stand in for the drivers in other rooms' tests: they must keep the interfaces'
// promises.
#include "tests/drivers/fake_devices.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "base/error.h"
#include "tests/drivers/manual_clock.h"

namespace gyrobench::drivers {
namespace {

TEST(FakeAxis, MovesWithTheClockAndArrives) {
  ManualClock clock;
  FakeAxis axis("inner", clock);
  EXPECT_THROW(axis.MoveBy(9, 3, 100), DeviceError) << "not open";
  axis.Open();
  axis.MoveBy(-9, 3, 100);
  EXPECT_THROW(axis.MoveBy(1, 1, 1), DeviceError) << "still moving";
  clock.Advance(FromSeconds(1.0));
  EXPECT_DOUBLE_EQ(axis.Read().commanded_deg, -3.0);
  EXPECT_TRUE(axis.Read().moving);
  clock.Advance(FromSeconds(10.0));
  EXPECT_DOUBLE_EQ(axis.Read().commanded_deg, -9.0);
  EXPECT_FALSE(axis.Read().moving);
}

TEST(FakeAxis, StopsWhereItIs) {
  ManualClock clock;
  FakeAxis axis("inner", clock);
  axis.Open();
  axis.MoveBy(9, 3, 100);
  clock.Advance(FromSeconds(2.0));
  axis.Stop();
  clock.Advance(FromSeconds(5.0));
  EXPECT_DOUBLE_EQ(axis.Read().commanded_deg, 6.0);
  EXPECT_THAT(axis.calls(), testing::ElementsAre("open", "move 9 deg at 3 deg/s", "stop"));
}

TEST(FakeAxis, AnAlarmIsAFaultUntilItIsCleared) {
  ManualClock clock;
  FakeAxis axis("inner", clock);
  axis.Open();
  axis.SetAlarm(5);
  EXPECT_TRUE(axis.Read().fault);
  EXPECT_EQ(axis.Read().alarm, 5);
  EXPECT_THROW(axis.MoveBy(9, 3, 100), DeviceError);
  axis.ClearAlarm();
  EXPECT_FALSE(axis.Read().fault);
}

TEST(FaultScript, FailsAsToldAndThenNoMore) {
  FaultScript script;
  script.PassNext();
  script.FailNext("cable", 2);
  EXPECT_NO_THROW(script.Step());
  EXPECT_THROW(script.Step(), DeviceError);
  EXPECT_THROW(script.Step(), DeviceError);
  EXPECT_NO_THROW(script.Step());
  script.FailAlways("dead");
  for (int i = 0; i < 5; ++i) EXPECT_THROW(script.Step(), DeviceError);
  script.Recover();
  EXPECT_NO_THROW(script.Step());
}

TEST(FakeAngleSensor, ReadsItsSourceToACount) {
  ManualClock clock;
  FakeAngleSensor sensor("inner", clock, [](Utime) { return -123.4567; });
  EXPECT_NEAR(sensor.Read().angle_deg, -123.4567, 0.5 * 360.0 / FakeAngleSensor::kCountsPerTurn);
  EXPECT_EQ(sensor.Read().utime, clock.Now());
}

TEST(FakeGyro, GivesEachSampleOnceAndCountsThoseMissed) {
  ManualClock clock;
  GyroIdentity identity;
  identity.sample_rate_hz = 200;
  identity.tick_rate_hz = 250000;
  identity.boot_count = 3;
  FakeGyro gyro(identity, clock, [](Utime) { return GyroRawSample{}; });
  gyro.Open();
  GyroBlock block;
  gyro.Read(block);
  EXPECT_EQ(block.samples.size(), 1U);
  gyro.Miss(4);
  clock.Advance(50'000);
  gyro.Read(block);
  EXPECT_EQ(block.missed, 4);
  ASSERT_EQ(block.samples.size(), 6U);
  EXPECT_EQ(block.samples.front().counter, 5);
  EXPECT_EQ(block.samples.back().tick, 12500);
  EXPECT_EQ(block.samples.back().utime, clock.Now());
  gyro.Restart();
  gyro.Read(block);
  EXPECT_EQ(block.boot_count, 4);
  EXPECT_EQ(block.samples.front().counter, 0);
}

}  // namespace
}  // namespace gyrobench::drivers
