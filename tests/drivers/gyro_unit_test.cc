#include "drivers/gyro_unit.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <memory>

#include "drivers/factory.h"
#include "tests/drivers/allocation_count.h"
#include "tests/drivers/fake_line.h"
#include "tests/drivers/gyro_unit_model.h"
#include "tests/drivers/manual_clock.h"

namespace gyrobench::drivers {
namespace {

using testing::AllOf;
using testing::ElementsAre;
using testing::HasSubstr;
using Transport = config::BusConfig::Transport;

constexpr double kTicksPerSecond = 250000.0;

config::GyroConfig Config() {
  config::GyroConfig config;
  config.map = GyroMapOfThePage();
  config.range_deg_s = 500;
  config.filter = 2;
  config.rate_hz = 200;
  config.accel_range_g = 16;
  return config;
}

class GyroUnitTest : public testing::Test {
 protected:
  GyroUnitTest() {
    line_.Connect(21, model_);
    gyro_ = MakeGyro(Config(), bus_);
  }
  // Time passes for the host and, with samples every 5 ms of its own clock, for the unit.
  void Pass(int samples) {
    model_.Take(samples);
    clock_.Advance(Utime{5000} * samples);
  }
  std::string OpenFailure(const config::GyroConfig& config) {
    try {
      MakeGyro(config, bus_)->Open();
    } catch (const Error& error) {
      return error.what();
    }
    return "";
  }
  // Reads and checks that each sample is the one of its number.
  void ReadInto(GyroBlock& block) {
    gyro_->Read(block);
    for (const GyroRawSample& sample : block.samples) {
      const auto raw = GyroUnitModel::Raw(static_cast<std::uint32_t>(sample.counter));
      ASSERT_THAT(sample.accel_lsb, ElementsAre(raw[0], raw[1], raw[2]));
      ASSERT_NEAR(sample.temperature_degC, raw[3] / 340.0 + 36.53, 1e-12);
      ASSERT_THAT(sample.gyro_lsb, ElementsAre(raw[4], raw[5], raw[6]));
    }
  }

  GyroUnitModel model_;
  FakeLine line_{Transport::kRtu};
  ManualClock clock_;
  std::unique_ptr<Clock::Participant> participant_ = clock_.Join("bus", Clock::Role::kResident);
  ModbusBus bus_{line_.Config(), clock_, *participant_};
  std::unique_ptr<Gyro> gyro_;
};

TEST_F(GyroUnitTest, OpenTellsWhoAnswersAndWithWhichSettings) {
  const GyroIdentity identity = gyro_->Open();
  EXPECT_EQ(identity.protocol_version, 1);
  EXPECT_EQ(identity.firmware, "2.3");
  EXPECT_EQ(identity.serial_number, 0x00050006U);
  EXPECT_EQ(identity.boot_count, 7);
  EXPECT_DOUBLE_EQ(identity.tick_rate_hz, kTicksPerSecond);
  EXPECT_DOUBLE_EQ(identity.sample_rate_hz, 200);
  EXPECT_DOUBLE_EQ(identity.gyro_lsb_per_deg_s, 65.5);
  EXPECT_DOUBLE_EQ(identity.accel_lsb_per_g, 2048);
  EXPECT_DOUBLE_EQ(identity.filter_bandwidth_hz, 98);
  EXPECT_DOUBLE_EQ(identity.filter_delay_s, 2.8e-3);
}

TEST_F(GyroUnitTest, OpenWritesOnlyTheSettingsThatDiffer) {
  gyro_->Open();
  EXPECT_THAT(model_.settings(), ElementsAre(1, 2, 4, 3));
  EXPECT_EQ(model_.settings_written(), 4);
  gyro_->Open();
  EXPECT_EQ(model_.settings_written(), 4);
  config::GyroConfig other = Config();
  other.filter = 5;
  MakeGyro(other, bus_)->Open();
  EXPECT_EQ(model_.settings_written(), 5);
  EXPECT_THAT(model_.settings(), ElementsAre(1, 5, 4, 3));
}

TEST_F(GyroUnitTest, ASettingThatDoesNotTakeIsAnError) {
  model_.LockSettings();
  EXPECT_THAT(OpenFailure(Config()), AllOf(HasSubstr("gyro range"), HasSubstr("0x0100"),
                                           HasSubstr("set to 1"), HasSubstr("reads back 0")));
}

TEST_F(GyroUnitTest, AWrongIdentityIsRefusedWithWhatWasExpected) {
  struct Wrong {
    std::size_t word;
    std::uint16_t value;
    const char* says;
  };
  const Wrong wrongs[] = {
      {0, 0x1234, "0x4742"}, {1, 9, "protocol version"}, {6, 0x70, "0x68"}, {8, 0xD091, "250000"}};
  for (const Wrong& wrong : wrongs) {
    const Words before = model_.Read(4, static_cast<std::uint16_t>(wrong.word), 1);
    model_.SetIdentity(wrong.word, wrong.value);
    EXPECT_THAT(OpenFailure(Config()), AllOf(HasSubstr("gyro"), HasSubstr("unit 21"),
                                             HasSubstr("expected"), HasSubstr(wrong.says)));
    model_.SetIdentity(wrong.word, before[0]);
  }
}

TEST_F(GyroUnitTest, AnotherSerialNumberIsRefused) {
  config::GyroConfig config = Config();
  config.serial_number = 0x00050006;
  EXPECT_EQ(OpenFailure(config), "");
  config.serial_number = 327687;
  EXPECT_THAT(OpenFailure(config),
              AllOf(HasSubstr("serial number"), HasSubstr("327687"), HasSubstr("327686")));
}

TEST_F(GyroUnitTest, SettingsThatTheMapLacksAreConfigErrors) {
  config::GyroConfig config = Config();
  config.range_deg_s = 300;
  EXPECT_THAT(OpenFailure(config), AllOf(HasSubstr("300"), HasSubstr("250, 500, 1000, 2000")));
  config = Config();
  config.filter = 7;
  EXPECT_THAT(OpenFailure(config), HasSubstr("gyro.filter = 7"));
  config = Config();
  config.rate_hz = 300;
  EXPECT_THAT(OpenFailure(config), HasSubstr("gyro.rate_hz = 300"));
}

TEST_F(GyroUnitTest, ReadsEverySampleOnceAndInOrder) {
  model_.StartAt(100, 0);
  gyro_->Open();
  GyroBlock block;
  std::int64_t expected = 100;
  for (const int samples : {10, 0, 1, 14, 7, 13}) {
    Pass(samples);
    ReadInto(block);
    EXPECT_EQ(block.missed, 0);
    ASSERT_EQ(block.samples.size(), static_cast<std::size_t>(samples));
    for (const GyroRawSample& sample : block.samples) {
      EXPECT_EQ(sample.counter, expected++);
      EXPECT_EQ(sample.tick, (sample.counter - 99) * 1250);
    }
  }
}

TEST_F(GyroUnitTest, OneRequestIsEnoughUnlessTheRingHoldsMore) {
  gyro_->Open();
  GyroBlock block;
  const auto requests = [&](int samples) {
    Pass(samples);
    const std::size_t before = line_.requests().size();
    ReadInto(block);
    EXPECT_EQ(block.samples.size(), static_cast<std::size_t>(samples));
    return line_.requests().size() - before;
  };
  EXPECT_EQ(requests(0), 1U);
  EXPECT_EQ(requests(14), 1U);
  EXPECT_EQ(requests(15), 2U);
  EXPECT_EQ(requests(50), 4U);
}

// What comes in while the ring is drained is left to the next read: a read ends.
TEST_F(GyroUnitTest, AReadDoesNotChaseNewSamples) {
  gyro_->Open();
  Pass(30);
  model_.TakeOnDemand(14);
  GyroBlock block;
  ReadInto(block);
  EXPECT_EQ(block.samples.size(), 30U);
}

TEST_F(GyroUnitTest, ALostReplyLosesNoSample) {
  gyro_->Open();
  GyroBlock block;
  std::int64_t expected = 0;
  for (const LineFault::Kind kind :
       {LineFault::kLostReply, LineFault::kBadChecksum, LineFault::kTruncated, LineFault::kNone}) {
    Pass(12);
    line_.Inject(kind);
    ReadInto(block);
    EXPECT_EQ(block.missed, 0);
    for (const GyroRawSample& sample : block.samples) EXPECT_EQ(sample.counter, expected++);
  }
  EXPECT_EQ(expected, 48);
}

TEST_F(GyroUnitTest, SamplesThatWereOverwrittenAreCounted) {
  gyro_->Open();
  Pass(static_cast<int>(GyroUnitModel::kCapacity) + 9);
  GyroBlock block;
  ReadInto(block);
  EXPECT_EQ(block.missed, 9);
  EXPECT_EQ(block.samples.size(), GyroUnitModel::kCapacity);
  EXPECT_EQ(block.samples.front().counter, 9);
}

// Nobody reads a unit between a failure and the next Open.
TEST_F(GyroUnitTest, SamplesThatPassWhileAUnitIsOpenedAgainAreCountedOnce) {
  gyro_->Open();
  Pass(5);
  GyroBlock block;
  ReadInto(block);
  Pass(7);
  gyro_->Open();
  Pass(3);
  gyro_->Open();
  Pass(2);
  ReadInto(block);
  EXPECT_EQ(block.missed, 10);
  EXPECT_EQ(block.samples.size(), 2U);
  EXPECT_EQ(block.samples.front().counter, 15);
  Pass(2);
  ReadInto(block);
  EXPECT_EQ(block.missed, 0);
}

TEST_F(GyroUnitTest, OfATickThatWentBackTheSamplesUntilTheNextOpenAreCountedToo) {
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

TEST_F(GyroUnitTest, NumbersAndTicksGoOnOverTheirWraps) {
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
TEST_F(GyroUnitTest, ALongGapBetweenSamplesKeepsTheTicksExact) {
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

TEST_F(GyroUnitTest, ARestartIsRecognisedAndEverythingBeginsAnew) {
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

// The same shape, unit, function and checksum: only the content shows that it answers an older
// request.
TEST_F(GyroUnitTest, AnOlderBlockIsNotTakenForTheAnswer) {
  gyro_->Open();
  GyroBlock block;
  Pass(5);
  ReadInto(block);
  Pass(6);
  line_.Inject(LineFault::kRepeatOld, 0, 2);
  ReadInto(block);
  EXPECT_EQ(block.missed, 0);
  ASSERT_EQ(block.samples.size(), 6U);
  EXPECT_EQ(block.samples.front().counter, 5);
  Pass(4);
  line_.Inject(LineFault::kRepeatOld, 0, 3);
  EXPECT_THROW(gyro_->Read(block), DeviceError);
  ReadInto(block);
  EXPECT_EQ(block.samples.front().counter, 11);
}

// A reply that a failed read left behind comes in front of the next one's.
TEST_F(GyroUnitTest, AReplyHeldUpOverAFailedReadLosesAndRepeatsNothing) {
  config::BusConfig config = line_.Config();
  config.retries = 0;
  ModbusBus bus(config, clock_, *participant_);
  gyro_ = MakeGyro(Config(), bus);
  gyro_->Open();
  GyroBlock block;
  Pass(5);
  line_.Inject(LineFault::kHeld);
  EXPECT_THROW(gyro_->Read(block), DeviceError);
  std::int64_t expected = 0;
  for (const int samples : {3, 4}) {
    Pass(samples);
    ReadInto(block);
    EXPECT_EQ(block.missed, 0);
    for (const GyroRawSample& sample : block.samples) EXPECT_EQ(sample.counter, expected++);
  }
  EXPECT_EQ(expected, 12);
}

TEST_F(GyroUnitTest, AReadAllocatesNothingOnceItsBlockHasGrown) {
  gyro_->Open();
  GyroBlock block;
  Pass(14);
  gyro_->Read(block);
  for (int reads = 0; reads < 5; ++reads) {
    Pass(14);
    const std::int64_t before = AllocationsOfThisThread();
    gyro_->Read(block);
    EXPECT_EQ(AllocationsOfThisThread(), before);
    EXPECT_EQ(block.samples.size(), 14U);
  }
}

TEST_F(GyroUnitTest, ATickThatGoesBackWithoutARestartIsAnErrorInTheEnd) {
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

TEST_F(GyroUnitTest, ATickThatStandsStillIsAnErrorInTheEnd) {
  gyro_->Open();
  Pass(5);
  GyroBlock block;
  ReadInto(block);
  clock_.Advance(FromSeconds(1.0));
  EXPECT_THROW(gyro_->Read(block), DeviceError);
}

// A resonator 0.2 % off is a scale error unless the ticks are mapped to host time.
TEST_F(GyroUnitTest, SampleTimesFollowTheHostsClockNotTheUnits) {
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

TEST_F(GyroUnitTest, SampleTimesIncreaseStrictlyHoweverTheBusJitters) {
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

TEST_F(GyroUnitTest, ErrorCountersOfTheUnitAreReadAlong) {
  gyro_->Open();
  GyroBlock block;
  ReadInto(block);
  EXPECT_EQ(block.samples_lost, 11U);
  EXPECT_EQ(block.sensor_bus_errors, 12U);
  EXPECT_EQ(block.frames_rejected, 13U);
  model_.SetCounters(0x10002, 0x30004, 0x50006);
  model_.Idle(static_cast<std::uint32_t>(5 * kTicksPerSecond));
  ReadInto(block);
  EXPECT_EQ(block.samples_lost, 0x10002U);
  EXPECT_EQ(block.sensor_bus_errors, 0x30004U);
  EXPECT_EQ(block.frames_rejected, 0x50006U);
}

TEST_F(GyroUnitTest, TheBlocksTickAndTimeBelongTogether) {
  gyro_->Open();
  Pass(3);
  model_.Idle(17);
  GyroBlock block;
  const Utime request = clock_.Now();
  ReadInto(block);
  EXPECT_EQ(block.tick, 3 * 1250 + 17);
  EXPECT_NEAR(static_cast<double>(block.utime - request), 998, 1);
}

TEST_F(GyroUnitTest, ABlockSaysWhenTheUnitStarted) {
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

TEST_F(GyroUnitTest, WhereTickAndSampleNumberDisagreeTheStartIsNotKnown) {
  model_.SetIdentity(9, 200);
  model_.StartAt(2'000'000, 3600U * 250'000U);
  gyro_->Open();
  GyroBlock block;
  Pass(3);
  ReadInto(block);
  EXPECT_FALSE(block.boot_utime);
}

TEST_F(GyroUnitTest, AReadBeforeOpenIsAnError) {
  GyroBlock block;
  EXPECT_THROW(gyro_->Read(block), DeviceError);
}

}  // namespace
}  // namespace gyrobench::drivers
