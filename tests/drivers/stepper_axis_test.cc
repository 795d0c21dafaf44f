#include "drivers/stepper_axis.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <atomic>
#include <cmath>
#include <memory>

#include "drivers/factory.h"
#include "tests/drivers/fake_line.h"
#include "tests/drivers/manual_clock.h"

namespace gyrobench::drivers {
namespace {

using testing::AllOf;
using testing::HasSubstr;

constexpr std::uint16_t kStatus = 0x1003, kPosition = 0x602A, kPath = 0x6200, kAlarm = 0x2203;
constexpr std::uint16_t kReady = 0x0032, kMoving = 0x0006, kDisabled = 0x0030;

// Leadshine RS, hardware.md.
config::AxisConfig InnerAxis() {
  config::AxisConfig axis;
  axis.name = "inner";
  axis.drive.unit = 3;
  config::DriveMap& map = axis.drive.map;
  map.model = "drive of the test";
  map.pulses_per_turn_address = 0x0001;
  map.enable_address = 0x000F;
  map.status_address = kStatus;
  map.position_address = kPosition;
  map.alarm_address = kAlarm;
  map.control_address = 0x1801;
  map.trigger_address = 0x6002;
  map.path_address = kPath;
  return axis;
}

// A drive that arrives at once when its path is started.
class DriveUnit : public RegisterUnit {
 public:
  DriveUnit() {
    SetHolding(0x0001, {10000});
    SetHolding(0x000F, {1});
    SetHolding(kStatus, {kReady});
    SetHolding(kPosition, {0, 0});
    SetHolding(kAlarm, {0});
    OnWrite([this](std::uint16_t address, const Words& values, Registers& holding) {
      if (address == 0x000F && values[0] == 1 && enables) holding[kStatus] = kReady;
      if (address == 0x1801 && values[0] == 0x1111 && clears) holding[kAlarm] = 0;
      if (address == kPath && values.back() == 0x0010) Start(values, holding);
    });
  }
  std::atomic<bool> enables = true;
  std::atomic<bool> clears = true;
  // The last move's frame, and how many were made.
  Words path() const {
    const std::lock_guard lock(mutex_);
    return path_;
  }
  int moves() const {
    const std::lock_guard lock(mutex_);
    return moves_;
  }

 private:
  void Start(const Words& values, Registers& holding) {
    path_ = values;
    ++moves_;
    const std::uint32_t sum =
        (holding[kPosition] * 65536U + holding[kPosition + 1]) + (values[1] * 65536U + values[2]);
    holding[kPosition] = static_cast<std::uint16_t>(sum >> 16);
    holding[kPosition + 1] = static_cast<std::uint16_t>(sum & 0xFFFF);
  }

  Words path_;
  int moves_ = 0;
};

constexpr std::uint16_t kInputs = 0x0100;

config::AxisConfig WithInputs(int active_level) {
  config::AxisConfig axis = InnerAxis();
  axis.drive.map.inputs = config::DriveInputs{.address = kInputs,
                                              .emergency_stop_bit = 2,
                                              .limit_plus_bit = 0,
                                              .limit_minus_bit = 5,
                                              .active_level = active_level};
  return axis;
}

class StepperAxisTest : public testing::Test {
 protected:
  StepperAxisTest() {
    line_.Connect(3, drive_);
    axis_ = MakeAxis(InnerAxis(), bus_);
  }
  std::string Failure(const std::function<void()>& act) {
    try {
      act();
    } catch (const Error& error) {
      return error.what();
    }
    return "";
  }
  config::BusConfig BusConfig() {
    config::BusConfig config = line_.Config();
    config.retries = 0;
    return config;
  }

  bool hurries_ = false;
  DriveUnit drive_;
  FakeLine line_{Transport::kRtu};
  ManualClock clock_;
  std::unique_ptr<Clock::Participant> participant_ = clock_.Join("bus", Clock::Role::kResident);
  ModbusBus bus_{BusConfig(), clock_, *participant_, [this] { return hurries_; }};
  std::unique_ptr<Axis> axis_;
};

TEST_F(StepperAxisTest, SendsAMoveAsOneFrameOfPathZero) {
  axis_->Open();
  // 9 deg of table = one turn of the shaft; 12 deg/s = 80 rpm; 100 deg/s^2 = 666.7 rpm/s = 1500 ms
  // per 1000 rpm.
  EXPECT_DOUBLE_EQ(axis_->MoveBy(-9.0, 12.0, 100.0), 12.0);
  EXPECT_THAT(drive_.path(),
              testing::ElementsAre(0x0041, 0xFFFF, 0x10000 - 10000, 80, 1500, 1500, 0, 0x0010));
  EXPECT_DOUBLE_EQ(axis_->Read().commanded_deg, -9.0);
}

TEST_F(StepperAxisTest, ReportsEachStatusBitAsItself) {
  axis_->Open();
  const auto read = [&](std::uint16_t status) {
    drive_.SetHolding(kStatus, {status});
    return axis_->Read();
  };
  EXPECT_TRUE(read(kMoving).enabled && read(kMoving).moving && !read(kMoving).fault);
  EXPECT_TRUE(read(kReady).enabled && !read(kReady).moving && !read(kReady).fault);
  EXPECT_TRUE(!read(kDisabled).enabled && !read(kDisabled).moving);
  drive_.SetHolding(kAlarm, {0x0E1});
  EXPECT_TRUE(read(0x0001).fault);
  EXPECT_EQ(read(0x0001).alarm, 0x0E1);
  EXPECT_EQ(read(kReady).alarm, 0);
}

// The remainder of a pulse is carried: however many turns, the table is where their sum says.
TEST_F(StepperAxisTest, RepeatedTurnsDoNotDrift) {
  axis_->Open();
  const double pulse_deg = 360.0 / (40.0 * 10000);
  double asked_deg = 0.0;
  for (int i = 0; i < 300; ++i) {
    const double angle_deg = i % 3 == 0 ? -7.00031 : 10.00047;
    axis_->MoveBy(angle_deg, 10.0, 100.0);
    asked_deg += angle_deg;
    ASSERT_NEAR(axis_->Read().commanded_deg, asked_deg, 0.5 * pulse_deg + 1e-9);
  }
}

TEST_F(StepperAxisTest, FollowsTheDrivesCounterOverItsWrap) {
  drive_.SetHolding(kPosition, {0x7FFF, 0xFFFF - 5000});
  axis_->Open();
  const double before_deg = axis_->Read().commanded_deg;
  axis_->MoveBy(9.0, 10.0, 100.0);
  EXPECT_NEAR(axis_->Read().commanded_deg - before_deg, 9.0, 1e-9);
}

TEST_F(StepperAxisTest, RefusesADriveOfOtherPulses) {
  drive_.SetHolding(0x0001, {1600});
  EXPECT_THAT(Failure([&] { axis_->Open(); }),
              AllOf(HasSubstr("axis.inner drive"), HasSubstr("unit 3"), HasSubstr("0x0001"),
                    HasSubstr("10000"), HasSubstr("1600")));
}

TEST_F(StepperAxisTest, EnablesADriveThatIsNot) {
  drive_.SetHolding(0x000F, {0});
  drive_.SetHolding(kStatus, {kDisabled});
  axis_->Open();
  EXPECT_EQ(drive_.Holding(0x000F), 1);
  EXPECT_TRUE(axis_->Read().enabled);
}

TEST_F(StepperAxisTest, ADriveThatStaysDisabledIsAnError) {
  drive_.SetHolding(kStatus, {kDisabled});
  drive_.enables = false;
  EXPECT_THAT(Failure([&] { axis_->Open(); }), AllOf(HasSubstr("enabled"), HasSubstr("0x0030")));
}

TEST_F(StepperAxisTest, AFaultIsNamedAtOpenAndBeforeAMove) {
  axis_->Open();
  drive_.SetHolding(kStatus, {0x0001});
  drive_.SetHolding(kAlarm, {0x0E1});
  EXPECT_THAT(Failure([&] { axis_->MoveBy(9, 10, 100); }), HasSubstr("alarm 0xE1"));
  EXPECT_THAT(Failure([&] { axis_->Open(); }), HasSubstr("alarm 0xE1"));
  EXPECT_EQ(drive_.moves(), 0);
}

// It is to be stopped before anything else of it is looked at.
TEST_F(StepperAxisTest, SaysWhetherItMovesWhateverElseIsWrongWithIt) {
  EXPECT_FALSE(axis_->IsMoving());
  drive_.SetHolding(0x0001, {1600});
  drive_.SetHolding(kAlarm, {0x0E1});
  drive_.SetHolding(kStatus, {kMoving | 1});
  EXPECT_TRUE(axis_->IsMoving());
  axis_->Stop();
  EXPECT_EQ(drive_.Holding(0x6002), 0x40);
  EXPECT_THAT(Failure([&] { axis_->Open(); }), HasSubstr("1600"));
}

TEST_F(StepperAxisTest, DoesNotMoveWhileMovingOrDisabled) {
  axis_->Open();
  for (const std::uint16_t status : {kMoving, kDisabled}) {
    drive_.SetHolding(kStatus, {status});
    EXPECT_THAT(Failure([&] { axis_->MoveBy(9, 10, 100); }), HasSubstr("move refused"));
  }
  EXPECT_EQ(drive_.moves(), 0);
}

// A relative move done twice is a table in the wrong place.
TEST_F(StepperAxisTest, AMoveWhoseReplyIsLostIsNotMadeTwice) {
  axis_->Open();
  line_.Inject(LineFault::kNone, 0, 2);  // status and position before the move
  line_.Inject(LineFault::kLostReply);
  axis_->MoveBy(9.0, 10.0, 100.0);
  EXPECT_EQ(drive_.moves(), 1);
}

TEST_F(StepperAxisTest, AMoveWhoseRequestIsLostIsSentAgain) {
  axis_->Open();
  line_.Inject(LineFault::kNone, 0, 2);
  line_.Inject(LineFault::kLostRequest);
  axis_->MoveBy(9.0, 10.0, 100.0);
  EXPECT_EQ(drive_.moves(), 1);
  EXPECT_DOUBLE_EQ(axis_->Read().commanded_deg, 9.0);
}

TEST_F(StepperAxisTest, AMoveThatTheDriveRefusesIsAnErrorAtOnce) {
  axis_->Open();
  line_.Inject(LineFault::kNone, 0, 2);
  line_.Inject(LineFault::kException, 3);
  EXPECT_THAT(Failure([&] { axis_->MoveBy(9, 10, 100); }), HasSubstr("illegal data value"));
  EXPECT_EQ(drive_.moves(), 0);
}

TEST_F(StepperAxisTest, StopIsTriedSeveralTimes) {
  axis_->Open();
  line_.Inject(LineFault::kLostRequest, 0, 2);
  axis_->Stop();
  EXPECT_EQ(drive_.Holding(0x6002), 0x40);
  line_.Inject(LineFault::kLostRequest, 0, 3);
  EXPECT_THAT(Failure([&] { axis_->Stop(); }), HasSubstr("quick stop"));
}

TEST_F(StepperAxisTest, AnAlarmThatStaysIsAnError) {
  axis_->Open();
  drive_.SetHolding(kAlarm, {0x0E1});
  EXPECT_NO_THROW(axis_->ClearAlarm());
  drive_.SetHolding(kAlarm, {0x0E1});
  drive_.clears = false;
  EXPECT_THAT(Failure([&] { axis_->ClearAlarm(); }), HasSubstr("0xE1"));
}

// A stop of another axis waits for the line meanwhile.
TEST_F(StepperAxisTest, WhileAStopWaitsItIsNotAskedAgainWhetherItHasSettled) {
  hurries_ = true;
  drive_.SetHolding(kStatus, {kDisabled});
  drive_.enables = false;
  const Utime begin = clock_.Now();
  EXPECT_THAT(Failure([this] { axis_->Open(); }), HasSubstr("does not become enabled"));
  drive_.clears = false;
  drive_.SetHolding(kAlarm, {0x21});
  EXPECT_THAT(Failure([this] { axis_->ClearAlarm(); }), HasSubstr("stays after it was cleared"));
  EXPECT_EQ(clock_.Now(), begin);
  drive_.SetHolding(kStatus, {kReady});
  // The reply of the third request is lost: after status and position, the move's.
  line_.Inject(LineFault::kNone, 0, 2);
  line_.Inject(LineFault::kLostRequest);
  EXPECT_NE(Failure([this] { axis_->MoveBy(9, 9, 90); }), "");
  EXPECT_EQ(drive_.moves(), 0);
}

// Whoever stops several comes back to it (Acquisition::PostStop).
TEST_F(StepperAxisTest, WhileAStopOfAnotherWaitsASilentDriveIsToldOnce) {
  axis_->Open();
  hurries_ = true;
  const std::size_t before = line_.requests().size();
  line_.Inject(LineFault::kLostRequest, 0, 9);
  EXPECT_THAT(Failure([&] { axis_->Stop(); }), HasSubstr("quick stop"));
  EXPECT_EQ(line_.requests().size(), before + 1);
}

TEST(StepperMovePlan, KeepsWithinWhatWasAskedForAcceleration) {
  const config::AxisConfig axis = InnerAxis();
  for (const double acceleration_deg_s2 : {4.7, 17.3, 100.0, 199.9}) {
    const StepperMove move = PlanStepperMove(axis, 0, 9, 10, acceleration_deg_s2);
    const double planned_deg_s2 = 1000.0 / (move.ramp_ms_per_1000rpm * 1e-3) * 6.0 / 40.0;
    EXPECT_LE(planned_deg_s2, acceleration_deg_s2 * (1 + 1e-9));
    EXPECT_GT(planned_deg_s2, acceleration_deg_s2 * 0.99);
  }
}

TEST(StepperMovePlan, UsesTheNearestWholeRpmButNeverMoreThanTheAxisMayDo) {
  config::AxisConfig axis = InnerAxis();
  for (double rate_deg_s = 0.2; rate_deg_s < 60; rate_deg_s *= 1.37) {
    const StepperMove move = PlanStepperMove(axis, 0, 9, rate_deg_s, 100);
    EXPECT_DOUBLE_EQ(move.rate_deg_s, move.rpm * 360.0 / 60.0 / 40.0);
    EXPECT_NEAR(move.rate_deg_s, rate_deg_s, 0.5 * 0.15 + 1e-9);
  }
  axis.max_rate_deg_s = 10.1;
  EXPECT_LE(PlanStepperMove(axis, 0, 9, 10.1, 100).rate_deg_s, 10.1);
}

TEST(StepperMovePlan, ADriveThatTurnsTheTableTheOtherWayGetsPulsesOfTheOtherSign) {
  config::AxisConfig axis = InnerAxis();
  const StepperMove with = PlanStepperMove(axis, 0, 9, 12, 100);
  axis.drive.sign = -1;
  const StepperMove against = PlanStepperMove(axis, 0, 9, 12, 100);
  EXPECT_EQ(with.pulses, -against.pulses);
  EXPECT_EQ(with.rpm, against.rpm);
}

TEST(StepperMovePlan, WhatTheDriveCannotExpressIsALimitError) {
  const config::AxisConfig axis = InnerAxis();
  const double nan = std::nan("");
  EXPECT_THROW(PlanStepperMove(axis, 0, nan, 10, 100), LimitError);
  EXPECT_THROW(PlanStepperMove(axis, 0, 9, nan, 100), LimitError);
  EXPECT_THROW(PlanStepperMove(axis, 0, 9, 10, nan), LimitError);
  EXPECT_THROW(PlanStepperMove(axis, 0, 1e-6, 10, 100), LimitError);
  EXPECT_THROW(PlanStepperMove(axis, 0, 1e7, 10, 100), LimitError);
  EXPECT_THROW(PlanStepperMove(axis, 0, 9, 0.05, 100), LimitError);
  EXPECT_THROW(PlanStepperMove(axis, 0, 9, -10, 100), LimitError);
  EXPECT_THROW(PlanStepperMove(axis, 0, 9, 1e9, 100), LimitError);
  EXPECT_THROW(PlanStepperMove(axis, 0, 9, 10, 0), LimitError);
  EXPECT_THROW(PlanStepperMove(axis, 0, 9, 10, 1.0), LimitError);
}

TEST_F(StepperAxisTest, ReadsTheInputsThatTheMapHasAtTheirActiveLevel) {
  for (const int level : {1, 0}) {
    axis_ = MakeAxis(WithInputs(level), bus_);
    for (const int bit : {0, 2, 5, 7}) {
      const auto active = static_cast<std::uint16_t>(1 << bit);
      drive_.SetHolding(kInputs, {level == 1 ? active : static_cast<std::uint16_t>(~active)});
      const AxisState state = axis_->Read();
      EXPECT_EQ(state.limit_plus, bit == 0) << level << " " << bit;
      EXPECT_EQ(state.emergency_stop, bit == 2) << level << " " << bit;
      EXPECT_EQ(state.limit_minus, bit == 5) << level << " " << bit;
    }
  }
}

TEST_F(StepperAxisTest, MovesAwayFromALimitAndNotTowardsIt) {
  axis_ = MakeAxis(WithInputs(1), bus_);
  drive_.SetHolding(kInputs, {1 << 5});
  axis_->Open();
  EXPECT_THAT(Failure([&] { axis_->MoveBy(-9.0, 10.0, 50.0); }),
              AllOf(HasSubstr("inner"), HasSubstr("limit input - acts")));
  EXPECT_EQ(drive_.moves(), 0);
  axis_->MoveBy(9.0, 10.0, 50.0);
  EXPECT_EQ(drive_.moves(), 1);
}

TEST_F(StepperAxisTest, IsNotOpenedWhileItsEmergencyStopActs) {
  axis_ = MakeAxis(WithInputs(1), bus_);
  drive_.SetHolding(kInputs, {1 << 2});
  EXPECT_THAT(Failure([&] { axis_->Open(); }),
              AllOf(HasSubstr("emergency stop input acts"), HasSubstr("Release")));
  drive_.SetHolding(kInputs, {0});
  EXPECT_NO_THROW(axis_->Open());
}

}  // namespace
}  // namespace gyrobench::drivers
