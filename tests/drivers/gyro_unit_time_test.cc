// When a gyro unit's samples were: ticks, their wraps, gaps and restarts, and the host's clock.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <cstdint>

#include "tests/drivers/gyro_unit_fixture.h"

namespace gyrobench::drivers {
namespace {

using GyroUnitTime = GyroUnitTest;
using testing::AllOf;
using testing::ElementsAre;
using testing::HasSubstr;

TEST_F(GyroUnitTime, OfATickThatWentBackTheSamplesUntilTheNextOpenAreCountedToo) {
  model_.StartAt(1000, 5'000'000);
  gyro_->Open();
  model_.StartAt(1040, 4'000'000);
  GyroBlock block;
  EXPECT_THROW(gyro_->Read(block), DeviceError);
  gyro_->Open();
  Pass(3);
  gyro_->Read(block);
  EXPECT_EQ(block.missed, 40);
  EXPECT_EQ(block.samples.front().counter, 1040);
}

TEST_F(GyroUnitTime, NumbersAndTicksGoOnOverTheirWraps) {
  const std::uint32_t number = 0xFFFFFFF0, tick = 0xFFFFFFFF - 20 * 1250;
  model_.StartAt(number, tick);
  gyro_->Open();
  GyroBlock block;
  std::int64_t expected = number;
  for (int reads = 0; reads < 10; ++reads) {
    Pass(11);
    gyro_->Read(block);
    EXPECT_EQ(block.missed, 0);
    ASSERT_EQ(block.samples.size(), 11U);
    for (const GyroRawSample& sample : block.samples) {
      EXPECT_EQ(sample.counter, expected++);
      EXPECT_EQ(sample.tick, tick + 1250 * (sample.counter - number + 1));
      EXPECT_EQ(sample.gyro_lsb[0],
                GyroUnitModel::Raw(static_cast<std::uint32_t>(sample.counter))[4]);
    }
  }
}

// 0xFFFF stands for any longer time: the sample after it is fetched as the first of a block of its
// own.
TEST_F(GyroUnitTime, ALongGapBetweenSamplesKeepsTheTicksExact) {
  gyro_->Open();
  model_.Take(3);
  model_.Take(1, 0xFFFF);
  model_.Take(1, 1'000'000);
  model_.Take(2);
  GyroBlock block;
  ReadInto(block);
  std::vector<std::int64_t> ticks;
  for (const GyroRawSample& sample : block.samples) ticks.push_back(sample.tick);
  EXPECT_THAT(ticks, ElementsAre(1250, 2500, 3750, 69285, 1069285, 1070535, 1071785));
}

TEST_F(GyroUnitTime, ARestartIsRecognisedAndEverythingBeginsAnew) {
  gyro_->Open();
  GyroBlock block;
  Pass(10);
  ReadInto(block);
  EXPECT_EQ(block.boot_count, 7);
  const Utime last = block.samples.back().utime;
  model_.Restart(123'456'789);
  Pass(5);
  ReadInto(block);
  EXPECT_EQ(block.boot_count, 8);
  EXPECT_TRUE(block.samples.empty());
  EXPECT_THAT(model_.settings(), ElementsAre(1, 2, 4, 3)) << "settings are written again";
  Pass(4);
  ReadInto(block);
  ASSERT_EQ(block.samples.size(), 4U);
  EXPECT_EQ(block.samples.front().counter, 5);
  EXPECT_GT(block.samples.front().utime, last);
  EXPECT_NEAR(static_cast<double>(block.samples.back().utime), static_cast<double>(clock_.Now()),
              2000);
}

TEST_F(GyroUnitTime, ATickThatGoesBackWithoutARestartIsAnErrorInTheEnd) {
  model_.StartAt(1000, 5'000'000);
  gyro_->Open();
  model_.StartAt(1000, 4'000'000);
  GyroBlock block;
  try {
    gyro_->Read(block);
    FAIL() << "no error";
  } catch (const DeviceError& error) {
    EXPECT_THAT(error.what(), AllOf(HasSubstr("gyro"), HasSubstr("5000000"), HasSubstr("4000000")));
  }
}

TEST_F(GyroUnitTime, ATickThatStandsStillIsAnErrorInTheEnd) {
  gyro_->Open();
  Pass(5);
  GyroBlock block;
  ReadInto(block);
  clock_.Advance(FromSeconds(1.0));
  EXPECT_THROW(gyro_->Read(block), DeviceError);
}

// A resonator 0.2 % off is a scale error unless the ticks are mapped to host time.
TEST_F(GyroUnitTime, SampleTimesFollowTheHostsClockNotTheUnits) {
  gyro_->Open();
  GyroBlock block;
  Utime first = 0, last = 0;
  std::int64_t first_counter = 0, last_counter = 0;
  for (int reads = 0; reads < 400; ++reads) {
    model_.Take(10);
    clock_.Advance(50'100);  // 10 samples of 5 ms take 0.2 % longer on the host's clock
    ReadInto(block);
    for (const GyroRawSample& sample : block.samples) {
      EXPECT_GT(sample.utime, last);
      last = sample.utime;
      last_counter = sample.counter;
      if (reads == 200 && first == 0) {
        first = sample.utime;
        first_counter = sample.counter;
      }
    }
  }
  const double period_us =
      static_cast<double>(last - first) / static_cast<double>(last_counter - first_counter);
  EXPECT_NEAR(period_us, 5010.0, 0.01);
}

TEST_F(GyroUnitTime, SampleTimesIncreaseStrictlyHoweverTheBusJitters) {
  gyro_->Open();
  GyroBlock block;
  Utime last = 0;
  for (int reads = 0; reads < 200; ++reads) {
    model_.Take(8);
    clock_.Advance(40'000 + (reads % 2 == 0 ? 30'000 : -30'000));
    ReadInto(block);
    for (const GyroRawSample& sample : block.samples) {
      ASSERT_GT(sample.utime, last);
      last = sample.utime;
    }
  }
}

TEST_F(GyroUnitTime, TheBlocksTickAndTimeBelongTogether) {
  gyro_->Open();
  Pass(3);
  model_.Idle(17);
  GyroBlock block;
  const Utime request = clock_.Now();
  ReadInto(block);
  EXPECT_EQ(block.tick, 3 * 1250 + 17);
  EXPECT_NEAR(static_cast<double>(block.utime - request), 998, 1);
}

TEST_F(GyroUnitTime, ABlockSaysWhenTheUnitStarted) {
  model_.SetIdentity(9, 200);
  model_.StartAt(720'000, 3600U * 250'000U);  // an hour at 200 Hz
  gyro_->Open();
  GyroBlock block;
  Pass(3);
  ReadInto(block);
  ASSERT_TRUE(block.boot_utime);
  const Utime first = *block.boot_utime;
  EXPECT_NEAR(ToSeconds(block.utime - first), 3600.0, 0.1);
  Pass(1000);
  ReadInto(block);
  EXPECT_EQ(block.boot_utime, first) << "one moment, whatever the clocks do later";
  model_.Restart();
  Pass(4);
  ReadInto(block);
  ASSERT_TRUE(block.boot_utime);
  EXPECT_NEAR(ToSeconds(block.utime - *block.boot_utime), 0.02, 0.05);
}

TEST_F(GyroUnitTime, WhereTickAndSampleNumberDisagreeTheStartIsNotKnown) {
  model_.SetIdentity(9, 200);
  model_.StartAt(2'000'000, 3600U * 250'000U);
  gyro_->Open();
  GyroBlock block;
  Pass(3);
  ReadInto(block);
  EXPECT_FALSE(block.boot_utime);
}

}  // namespace
}  // namespace gyrobench::drivers
