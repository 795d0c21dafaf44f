#include "daemon/polled_device.h"

#include <gtest/gtest.h>

#include <vector>

#include "base/error.h"
#include "tests/drivers/manual_clock.h"

namespace gyrobench::daemon {
namespace {

constexpr Utime kPeriod = 100'000;
constexpr Utime kSilence = 1'000'000;

class PolledDeviceTest : public testing::Test {
 protected:
  // Polls whenever it is due, for `duration`.
  void PollFor(Utime duration) {
    const Utime end = clock_->Now() + duration;
    while (due_ <= end) {
      me_->WaitUntil(due_);
      due_ = device_.Poll();
    }
  }

  std::unique_ptr<VirtualClock> clock_ = MakeVirtualClock(kStart);
  std::unique_ptr<Clock::Participant> me_ = clock_->Join("test");
  int opened_ = 0;
  int read_ = 0;
  bool there_ = true;
  std::vector<std::string> reported_;
  PolledDevice device_{
      {"gyro", "gyro", "b", 21, false, ""},
      {[this] {
         if (!there_) throw DeviceError("gyro: no answer", {.device = "gyro", .action = "samples"});
         ++opened_;
       },
       [this] {
         if (!there_) throw DeviceError("gyro: no answer", {.device = "gyro", .action = "samples"});
         ++read_;
       },
       [] { return kPeriod; }},
      *clock_,
      kSilence,
      [this](const Fault& fault) {
        reported_.push_back(fault.source + "|" + fault.message + "|" + fault.failure.action);
      }};
  Utime due_ = kStart;
};

TEST_F(PolledDeviceTest, IsOpenedOnceAndThenReadAtItsRate) {
  PollFor(10 * kMicrosecondsPerSecond);
  EXPECT_EQ(opened_, 1);
  EXPECT_NEAR(read_, 100, 2);
  EXPECT_TRUE(device_.status().ok);
}

TEST_F(PolledDeviceTest, ADeviceThatWasNeverThereIsTriedAgainAndIsNoFault) {
  there_ = false;
  PollFor(10 * kMicrosecondsPerSecond);
  EXPECT_FALSE(device_.status().ok);
  EXPECT_EQ(device_.status().message, "gyro: no answer");
  EXPECT_TRUE(reported_.empty());
  there_ = true;
  PollFor(5 * kMicrosecondsPerSecond);
  EXPECT_TRUE(device_.status().ok);
}

TEST_F(PolledDeviceTest, SilenceIsReportedOnceAfterItsTimeAndIdentityIsCheckedAgain) {
  PollFor(kMicrosecondsPerSecond);
  there_ = false;
  PollFor(kSilence / 2);
  EXPECT_TRUE(reported_.empty());
  PollFor(10 * kSilence);
  ASSERT_EQ(reported_.size(), 1u);
  EXPECT_EQ(reported_[0], "gyro|gyro: no answer|samples");
  there_ = true;
  PollFor(5 * kMicrosecondsPerSecond);
  EXPECT_TRUE(device_.status().ok);
  EXPECT_EQ(opened_, 2);
}

TEST_F(PolledDeviceTest, OneLostReplyIsNoFault) {
  PollFor(kMicrosecondsPerSecond);
  there_ = false;
  PollFor(kPeriod);
  there_ = true;
  PollFor(kMicrosecondsPerSecond);
  EXPECT_TRUE(reported_.empty());
  EXPECT_EQ(opened_, 1);
}

}  // namespace
}  // namespace gyrobench::daemon
