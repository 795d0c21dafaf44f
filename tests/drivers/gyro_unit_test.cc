// Who a gyro unit is, what is set in it, and that every sample of its ring is read once.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstdint>

#include "tests/drivers/allocation_count.h"
#include "tests/drivers/gyro_unit_fixture.h"

namespace gyrobench::drivers {
namespace {

using testing::AllOf;
using testing::ElementsAre;
using testing::HasSubstr;

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

TEST(LineRecorder, AllocatesNothingForAUnitThatItKnows) {
  LineRecorder recorder(kStart);
  const char* const device = "a name that no short string holds";
  recorder.Add(device, 21, kStart, {});
  const std::int64_t before = AllocationsOfThisThread();
  for (int i = 0; i < 60; ++i) recorder.Add(device, 21, kStart + i * kMicrosecondsPerSecond, {});
  EXPECT_EQ(AllocationsOfThisThread(), before);
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

TEST_F(GyroUnitTest, AReadBeforeOpenIsAnError) {
  GyroBlock block;
  EXPECT_THROW(gyro_->Read(block), DeviceError);
}

}  // namespace
}  // namespace gyrobench::drivers
