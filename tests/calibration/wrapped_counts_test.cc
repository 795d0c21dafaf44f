// Counts of a signed word that were written as unsigned ones are told from those of a converter
// that is unsigned.
#include "calibration/signal/wrapped_counts.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>

namespace gyrobench::calibration {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;

MeasurementInfo Counts() {
  MeasurementInfo info;
  info.gyro_present = {false, false, true};
  return info;
}

std::optional<WrappedCounts::Finding> Watch(const std::function<double(int)>& count,
                                            const MeasurementInfo& info = Counts()) {
  WrappedCounts watch;
  watch.Start(info);
  for (int i = 0; i < 2000; ++i) watch.Add(0.01 * i, {kMissing, kMissing, count(i)});
  return watch.Found();
}

// Ten counts about `zero`, as a sensor at rest.
double Swing(int i) { return std::round(10.0 * std::sin(0.7 * i)); }
double Modulo(double count, double range) { return count < 0.0 ? count + range : count; }

TEST(WrappedCounts, AreThoseThatJumpByTheirRangeWhereTheRateGoesThroughZero) {
  const auto found = Watch([](int i) { return Modulo(Swing(i), 65536.0); });
  ASSERT_TRUE(found);
  EXPECT_EQ(found->channel, 2U);
  EXPECT_EQ(found->bits, 16);
  EXPECT_GT(found->jumps, 100);
  EXPECT_GT(std::fabs(found->to - found->from), 65000.0);
  const auto wide = Watch([](int i) { return Modulo(Swing(i), 4294967296.0); });
  ASSERT_TRUE(wide);
  EXPECT_EQ(wide->bits, 32);
}

TEST(WrappedCounts, AreNoneOfASignedWordOrOfAnUnsignedConverterAtRestOrSaturated) {
  EXPECT_FALSE(Watch(Swing));
  EXPECT_FALSE(Watch([](int i) { return 32768.0 + Swing(i); }));
  EXPECT_FALSE(Watch(
      [](int i) { return std::clamp(32768.0 + 60000.0 * std::sin(0.01 * i), 0.0, 65535.0); }));
  // A wider word that is never below zero.
  EXPECT_FALSE(Watch([](int i) { return 40000.0 + 39000.0 * std::sin(0.05 * i); }));
  MeasurementInfo given = Counts();
  given.gyro_lsb_zero = 32768.0;
  EXPECT_FALSE(Watch([](int i) { return Modulo(Swing(i), 65536.0); }, given));
  MeasurementInfo scaled = Counts();
  scaled.gyro_unit = RateUnit::kDegPerSecond;
  EXPECT_FALSE(Watch([](int i) { return Modulo(Swing(i), 65536.0); }, scaled));
}

// Of a count that was lost on the bus.
TEST(WrappedCounts, AreNotShownByOneStraySample) {
  EXPECT_FALSE(Watch([](int i) { return i == 700 ? 65535.0 : 200.0 + Swing(i); }));
  EXPECT_FALSE(Watch([](int i) { return i == 700 ? 0.0 : 65300.0 + Swing(i); }));
}

TEST(WrappedCounts, AreRefusedWithWhatToDo) {
  const Defect defect = DefectOf({2, 16, 42, 1.5, 3.0, 65533.0});
  RefuseWrappedCounts("a.csv", {});
  try {
    RefuseWrappedCounts("a.csv", {defect});
    FAIL();
  } catch (const std::exception& error) {
    EXPECT_THAT(error.what(),
                AllOf(HasSubstr("a.csv: "), HasSubstr("42 times"), HasSubstr("gyro z: 3 to 65533"),
                      HasSubstr("Take 65536 off every count above 32767")));
  }
}

}  // namespace
}  // namespace gyrobench::calibration
