// One moment and one name for each power-on of the sensor.
#include "daemon/power_on.h"

#include <gtest/gtest.h>

namespace gyrobench::daemon {
namespace {

constexpr Utime kBoot = 1'795'000'000'123'457;

drivers::GyroBlock Block(double after_boot_s, int boot_count = 7,
                         std::optional<Utime> boot_utime = kBoot) {
  drivers::GyroBlock block;
  block.utime = kBoot + FromSeconds(after_boot_s);
  block.boot_count = boot_count;
  block.boot_utime = boot_utime;
  return block;
}

TEST(PowerOnWatch, KeepsOneMomentUntilTheUnitStartsAnew) {
  PowerOnWatch watch;
  EXPECT_FALSE(watch.power_on());
  watch.Take(1001, Block(1.0));
  ASSERT_TRUE(watch.power_on());
  EXPECT_EQ(watch.power_on()->utime, kBoot);
  EXPECT_EQ(watch.power_on()->name, "2026-11-18T11:06:40.123457Z, sensor 1001, start 7");
  const std::string name = watch.power_on()->name;
  // Opened again after an hour, by a clock that is 0.25 % off: the same power-on.
  watch.Take(1001, Block(3600.0, 7, kBoot + FromSeconds(9.0)));
  EXPECT_EQ(watch.power_on()->utime, kBoot);
  EXPECT_EQ(watch.power_on()->name, name);
  watch.Take(1001, Block(3700.0, 8, kBoot + FromSeconds(3699.0)));
  ASSERT_TRUE(watch.power_on());
  EXPECT_EQ(watch.power_on()->utime, kBoot + FromSeconds(3699.0));
  EXPECT_NE(watch.power_on()->name, name);
}

TEST(PowerOnWatch, AStartThatTheUnitDidNotCountIsToldByItsTick) {
  PowerOnWatch watch;
  watch.Take(1001, Block(1.0));
  const std::string name = watch.power_on()->name;
  watch.Take(1001, Block(3600.0, 7, kBoot + FromSeconds(3500.0)));
  EXPECT_NE(watch.power_on()->name, name);
}

TEST(PowerOnWatch, SaysNothingWhereTheMomentIsNotKnown) {
  PowerOnWatch watch;
  watch.Take(1001, Block(1.0, 7, std::nullopt));
  EXPECT_FALSE(watch.power_on());
  // Known once, it stays known until the next start.
  watch.Take(1001, Block(2.0));
  watch.Take(1001, Block(3.0, 7, std::nullopt));
  EXPECT_TRUE(watch.power_on());
  watch.Take(1001, Block(4.0, 8, std::nullopt));
  EXPECT_FALSE(watch.power_on());
}

}  // namespace
}  // namespace gyrobench::daemon
