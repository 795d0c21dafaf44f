// The devices at work, with fakes of them: who is asked when, and what of it is told on.
#include "daemon/acquisition.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>

#include "base/error.h"
#include "tests/daemon/fake_stand.h"
#include "tests/drivers/manual_clock.h"

namespace gyrobench::daemon {
namespace {

using ::testing::Contains;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::Not;
using ::testing::SizeIs;

constexpr Utime kSecond = kMicrosecondsPerSecond;

class AcquisitionTest : public testing::Test {
 protected:
  explicit AcquisitionTest(config::StandConfig stand = StandOfFakes()) : stand_(std::move(stand)) {
    acquisition_.Start();
    acquisition_.AwaitFirstTry(*me_, 5 * kSecond);
  }
  ~AcquisitionTest() override {
    me_.reset();
    acquisition_.Stop();
  }
  void Wait(Utime duration) { me_->WaitUntil(clock_->Now() + duration); }
  double MoveBy(const std::string& axis, double angle_deg) {
    return acquisition_.MoveBy(*me_, axis, angle_deg, 10.0, 50.0, [] {});
  }
  std::vector<std::string> CallsOf(const std::string& axis) {
    return devices_.drives.at(axis)->calls();
  }

  const config::StandConfig stand_;
  std::unique_ptr<VirtualClock> clock_ = MakeVirtualClock(kStart);
  std::unique_ptr<Clock::Participant> me_ = clock_->Join("test");
  FakeStand devices_{*clock_};
  LcmPublisher publisher_{"memq://", "TEST"};
  Telemetry telemetry_{publisher_, [](const std::string&) {}};
  std::vector<std::string> silent_, faults_;
  Notices notices_;
  std::vector<Fault> told_;  // the same as faults_, with their fields
  Acquisition acquisition_{stand_,
                           *clock_,
                           devices_,
                           telemetry_,
                           [this](const Fault& fault) { silent_.push_back(fault.source); },
                           [this](const Fault& fault) {
                             faults_.push_back(fault.source + ": " + fault.message);
                             told_.push_back(fault);
                           },
                           notices_};
};

TEST_F(AcquisitionTest, OpensEveryDeviceAndSaysThatAllAreWell) {
  EXPECT_THAT(acquisition_.Devices(), SizeIs(8));
  for (const DeviceStatus& device : acquisition_.Devices()) EXPECT_TRUE(device.ok) << device.name;
  EXPECT_EQ(acquisition_.Sensor().identity.serial_number, 17u);
  EXPECT_THAT(faults_, IsEmpty());
}

TEST_F(AcquisitionTest, TakesEverySampleOfTheGyroOnce) {
  const std::int64_t before = acquisition_.Sensor().samples;
  Wait(10 * kSecond);
  // What lies between two polls is on its way.
  EXPECT_NEAR(static_cast<double>(acquisition_.Sensor().samples - before), 2000.0, 24.0);
  EXPECT_DOUBLE_EQ(acquisition_.Sensor().temperature_degC, 25.0);
  EXPECT_NEAR(acquisition_.Sensor().tick_ratio, 1.0, 1e-6);
}

TEST_F(AcquisitionTest, MovesTheAxisThatIsNamedAndNoOther) {
  EXPECT_EQ(MoveBy("middle", 30.0), 10.0);
  Wait(4 * kSecond);
  EXPECT_NEAR(acquisition_.ReadNow(*me_, "middle").reference.angle_deg, 30.0, 0.01);
  EXPECT_THAT(CallsOf("middle"), Contains("move 30 deg at 10 deg/s"));
  EXPECT_THAT(CallsOf("outer"), Not(Contains(HasSubstr("move"))));
  EXPECT_THAT(CallsOf("inner"), Not(Contains(HasSubstr("move"))));
  EXPECT_THROW(MoveBy("fourth", 1.0), LimitError);
}

TEST_F(AcquisitionTest, MovesNothingOnceTheRunIsToEnd) {
  const auto to_end = [] { throw DeviceError("the run is to end"); };
  EXPECT_THROW(acquisition_.MoveBy(*me_, "inner", 90.0, 10.0, 50.0, to_end), DeviceError);
  EXPECT_THAT(CallsOf("inner"), Not(Contains(HasSubstr("move"))));
}

TEST_F(AcquisitionTest, ReadsTheReferenceOfAnActiveAxisAtItsFullRate) {
  acquisition_.SetActiveAxes({"inner"});
  MoveBy("inner", 100.0);
  Wait(kSecond);
  // Never older than a reading at the full rate allows; those of idle axes may be.
  for (int i = 0; i < 50; ++i) {
    Wait(37'000);
    EXPECT_LE(clock_->Now() - acquisition_.Axis("inner").reference.utime, kSecond / 50);
  }
  const int inner = devices_.encoders.at("inner")->reads(),
            outer = devices_.encoders.at("outer")->reads();
  Wait(10 * kSecond);
  EXPECT_NEAR(devices_.encoders.at("inner")->reads() - inner, 500, 2);
  EXPECT_NEAR(devices_.encoders.at("outer")->reads() - outer, 20, 2);
}

TEST_F(AcquisitionTest, TellsOfADeviceThatFallsSilentOnceTheStandFilesTimeIsOver) {
  devices_.encoders.at("outer")->faults().FailAlways("encoder.outer: no answer");
  Wait(kSecond * 8 / 10);
  EXPECT_THAT(silent_, IsEmpty());
  Wait(2 * kSecond);
  EXPECT_THAT(silent_, ElementsAre("encoder.outer"));
  devices_.encoders.at("outer")->faults().Recover();
  Wait(3 * kSecond);
  for (const DeviceStatus& device : acquisition_.Devices()) EXPECT_TRUE(device.ok) << device.name;
}

TEST_F(AcquisitionTest, TellsOfADrivesAlarm) {
  devices_.drives.at("inner")->SetAlarm(0x21);
  Wait(kSecond);
  ASSERT_THAT(faults_, Not(IsEmpty()));
  EXPECT_THAT(faults_[0], HasSubstr("axis.inner: the drive reports alarm 33 (0x21)"));
  acquisition_.PostClearAlarms();
  Wait(kSecond);
  EXPECT_FALSE(acquisition_.Axis("inner").drive.fault);
}

TEST_F(AcquisitionTest, StopsEveryAxisWhereTheTableIsBeyondItsLimits) {
  acquisition_.SetActiveAxes({"inner"});
  devices_.off_deg["inner"] = 190.0;
  Wait(kSecond);
  const auto times = [this] {
    return std::ranges::count_if(faults_, [](const std::string& fault) {
      return fault.find("beyond its soft limits -180 .. 180 deg") != std::string::npos;
    });
  };
  EXPECT_EQ(times(), 1);
  for (const char* axis : {"outer", "middle", "inner"})
    EXPECT_THAT(CallsOf(axis), Contains("stop")) << axis;
  // Back within them and out again: that is another time.
  devices_.off_deg["inner"] = 0.0;
  Wait(kSecond);
  devices_.off_deg["inner"] = -190.0;
  Wait(kSecond);
  EXPECT_EQ(times(), 2);
}

TEST_F(AcquisitionTest, AnEmergencyStopOfOneDriveStopsAllAxesForAsLongAsItActs) {
  MoveBy("outer", 170.0);
  devices_.drives.at("inner")->SetInputs(true, false, false);
  Wait(kSecond);
  ASSERT_THAT(faults_, Not(IsEmpty()));
  EXPECT_THAT(faults_[0], HasSubstr("axis.inner: the emergency stop input of its drive acts"));
  EXPECT_EQ(told_[0].failure.action, "inputs");
  EXPECT_FALSE(devices_.drives.at("outer")->Read().moving);
  const auto times = [this] {
    return std::ranges::count_if(faults_, [](const std::string& fault) {
      return fault.find("emergency stop input") != std::string::npos;
    });
  };
  Wait(5 * kSecond);
  EXPECT_EQ(times(), 1);
  // Reset while it acts, the drive is not well, and nothing begins; released, it is enabled again.
  const auto drive = [this] {
    const std::vector<DeviceStatus> devices = acquisition_.Devices();
    return *std::ranges::find(devices, "axis.inner", &DeviceStatus::name);
  };
  acquisition_.PostRearm();
  Wait(5 * kSecond);
  EXPECT_FALSE(drive().ok);
  EXPECT_THAT(drive().message, HasSubstr("emergency stop"));
  devices_.drives.at("inner")->SetInputs(false, false, false);
  Wait(5 * kSecond);
  EXPECT_EQ(times(), 1);
  EXPECT_TRUE(drive().ok);
}

TEST_F(AcquisitionTest, ALimitThatIsReachedIsAFaultOnceSoThatTheAxisCanBeTurnedAway) {
  MoveBy("outer", 170.0);
  devices_.drives.at("inner")->SetInputs(false, false, true);
  Wait(kSecond);
  ASSERT_THAT(faults_, SizeIs(1));
  EXPECT_THAT(faults_[0], HasSubstr("axis.inner: the limit input - of its drive acts"));
  EXPECT_FALSE(devices_.drives.at("outer")->Read().moving);
  acquisition_.PostRearm();
  MoveBy("inner", 5.0);
  Wait(5 * kSecond);
  EXPECT_THAT(faults_, SizeIs(1));
  devices_.drives.at("inner")->SetInputs(false, false, false);
  Wait(kSecond);
  devices_.drives.at("inner")->SetInputs(false, false, true);
  Wait(kSecond);
  EXPECT_THAT(faults_, SizeIs(2));
}

TEST_F(AcquisitionTest, AFaultHasTheFieldsAndTheSamplesUpToIt) {
  acquisition_.SetActiveAxes({"inner"});
  Wait(5 * kSecond);
  devices_.drives.at("inner")->SetAlarm(33);
  Wait(kSecond);
  ASSERT_THAT(told_, Not(IsEmpty()));
  const Fault& fault = told_[0];
  EXPECT_EQ(fault.failure.device, "axis.inner drive");
  EXPECT_EQ(fault.failure.action, "status");
  EXPECT_EQ(fault.failure.code_kind, DeviceFailure::CodeKind::kAlarm);
  EXPECT_EQ(fault.failure.code, 33);
  ASSERT_THAT(fault.samples.axes, SizeIs(3));
  const LastSamples::Axis& inner = fault.samples.axes.back();
  EXPECT_EQ(inner.name, "inner");
  EXPECT_EQ(inner.drive.alarm, 33);
  ASSERT_THAT(inner.reference, SizeIs(20));
  ASSERT_THAT(fault.samples.gyro, SizeIs(20));
  // The newest of all that there were, in their order.
  for (std::size_t i = 1; i < 20; ++i) {
    EXPECT_GT(inner.reference[i].utime, inner.reference[i - 1].utime);
    EXPECT_EQ(fault.samples.gyro[i].counter, fault.samples.gyro[i - 1].counter + 1);
  }
  EXPECT_LE(inner.drive.utime - inner.reference.back().utime, kSecond / 5);
}

TEST_F(AcquisitionTest, StopsEveryAxisWhateverOneOfThemDoes) {
  devices_.drives.at("outer")->faults().FailAlways("axis.outer: no answer");
  devices_.drives.at("outer")->faults().fields.device = "axis.outer drive";
  try {
    acquisition_.StopAll(*me_);
    FAIL() << "a drive that did not stop was passed over";
  } catch (const DeviceError& error) {
    EXPECT_THAT(error.what(), HasSubstr("axis.outer: no answer"));
    EXPECT_EQ(error.failure().device, "axis.outer drive");
  }
  EXPECT_THAT(CallsOf("middle"), Contains("stop"));
  EXPECT_THAT(CallsOf("inner"), Contains("stop"));
}

TEST_F(AcquisitionTest, StopsTheAxesThatARunTurnsFirst) {
  acquisition_.SetActiveAxes({"inner"});
  std::vector<std::string> order;
  for (auto& [name, drive] : devices_.drives)
    drive->on_call = [&, axis = name](const std::string& call) {
      order.push_back(std::string(axis).append(" ").append(call));
    };
  acquisition_.StopAll(*me_);
  EXPECT_THAT(order, ElementsAre("inner stop", "outer stop", "middle stop"));
}

// Silent drives take their time; the one that turns is told before them, and before what was asked
// of its bus otherwise.
TEST_F(AcquisitionTest, AnOperatorsStopReachesTheAxisThatTurnsBeforeSilentOnes) {
  acquisition_.SetActiveAxes({"inner"});
  MoveBy("inner", 90.0);
  devices_.drives.at("outer")->faults().FailAlways("no answer");
  devices_.drives.at("middle")->faults().FailAlways("no answer");
  Wait(kSecond);
  std::vector<std::string> order;
  for (const auto& [name, drive] : devices_.drives) {
    drive->on_call = [&order, axis = name](const std::string& call) {
      if (call == "stop") order.push_back(axis);
    };
  }
  acquisition_.PostStopAll();
  Wait(kSecond / 10);
  ASSERT_GE(order.size(), 3u);
  EXPECT_EQ(order[0], "inner");
  EXPECT_EQ(std::ranges::count(order, "inner"), 1);
  // In turn, each with as many requests as a drive has that is alone on its line.
  for (std::size_t i = 1; i < order.size(); ++i)
    EXPECT_EQ(order[i], i % 2 == 1 ? "outer" : "middle");
  EXPECT_EQ(std::ranges::count(order, "outer"), 6);
  for (const auto& [name, drive] : devices_.drives) drive->on_call = {};
}

// Of one that was well until now nobody knows: it is told once before the other that turns, and
// again behind it. Whether or not somebody waits for the drives.
TEST_F(AcquisitionTest, AStopThatIsLostIsTriedAgainBehindTheOthersOfItsLine) {
  for (const bool waits : {false, true}) {
    std::vector<std::string> order;
    for (const auto& [name, drive] : devices_.drives) {
      drive->on_call = [&order, axis = name](const std::string& call) {
        if (call == "stop") order.push_back(axis);
      };
    }
    devices_.drives.at("outer")->faults().FailNext("no answer");
    if (waits) {
      EXPECT_NO_THROW(acquisition_.StopAll(*me_));
    } else {
      acquisition_.PostStopAll();
      Wait(kSecond / 10);
    }
    EXPECT_THAT(order, ElementsAre("outer", "middle", "inner", "outer"));
    EXPECT_THAT(faults_, IsEmpty());
  }
  for (const auto& [name, drive] : devices_.drives) drive->on_call = {};
}

TEST_F(AcquisitionTest, ATableThatMovesWithoutACommandIsAFaultAndAllIsStopped) {
  Wait(5 * kSecond);
  devices_.off_deg["middle"] = 3.0;
  Wait(3 * kSecond);
  ASSERT_THAT(faults_, SizeIs(1));
  EXPECT_THAT(faults_[0], HasSubstr("axis.middle: the table moves though nobody commanded it"));
  EXPECT_THAT(faults_[0], HasSubstr("deg from where it came to rest"));
  for (const char* axis : {"outer", "middle", "inner"})
    EXPECT_THAT(CallsOf(axis), Contains("stop")) << axis;
}

TEST_F(AcquisitionTest, ASensorOutsideItsRangeIsAFaultAndOutputsAreOff) {
  acquisition_.outputs()->Switch(*me_, "fan", true, [] {});
  devices_.temperature_degC = 84.0;
  Wait(kSecond);
  EXPECT_THAT(faults_, IsEmpty());
  devices_.temperature_degC = 91.5;
  Wait(kSecond);
  ASSERT_THAT(faults_, SizeIs(1)) << "told once";
  EXPECT_THAT(faults_[0], HasSubstr("91.5 degC, outside the part's range -40 .. 85 degC"));
  EXPECT_FALSE(devices_.relays->on.at("fan"));
  EXPECT_THAT(CallsOf("inner"), Contains("stop"));
}

TEST_F(AcquisitionTest, TellsWhetherAllDevicesAreWell) {
  std::vector<bool> told;
  acquisition_.WhenWellnessChanges([&](bool all_well) { told.push_back(all_well); });
  devices_.encoders.at("outer")->faults().FailAlways("no answer");
  Wait(5 * kSecond);
  devices_.encoders.at("outer")->faults().Recover();
  Wait(5 * kSecond);
  EXPECT_THAT(told, ElementsAre(false, true));
}

// A reference that is read once a second, and shows what was 1.5 s ago.
config::StandConfig SlowReferences() {
  config::StandConfig stand = StandOfFakes();
  for (config::AxisConfig& axis : stand.axes) {
    axis.encoder.rate_hz = 1.0;
    axis.encoder.map.delay_s = 1.5;
    axis.following_error_deg = 1.0;
  }
  return stand;
}

class SlowReference : public AcquisitionTest {
 protected:
  static constexpr Utime kStep = kSecond / 100;
  SlowReference() : AcquisitionTest(SlowReferences()) { acquisition_.SetActiveAxes({"inner"}); }
  double Inner() const { return devices_.drives.at("inner")->AngleDeg(); }
  // Waits while the sensor shows what was `delay` ago.
  void WaitDelayed(Utime duration, Utime delay) {
    for (Utime t = 0; t < duration; t += kStep) {
      were_deg_.push_back(Inner());
      const auto steps = static_cast<std::size_t>(delay / kStep);
      const double was_deg =
          were_deg_.size() > steps ? were_deg_[were_deg_.size() - 1 - steps] : were_deg_.front();
      devices_.off_deg["inner"] = was_deg - Inner();
      Wait(kStep);
    }
  }
  std::vector<double> were_deg_;
};

TEST_F(SlowReference, GuardsAMoveThatIsLongEnoughForTwoOfItsReadings) {
  MoveBy("inner", 170.0);
  for (int i = 0; i < 1000 && faults_.empty(); ++i) WaitDelayed(kStep, kForever / 2);
  ASSERT_THAT(faults_, SizeIs(1));
  EXPECT_THAT(faults_[0], HasSubstr("does not follow its drive"));
  Wait(kSecond / 10);
  // 1 deg, and 10 deg/s for 2 s, are allowed; two readings, and two polls, come after that.
  EXPECT_LT(Inner(), 21.0 + 10.0 * 3.2);
}

// The reading that the way back is counted from is late as well: by 15 deg, and the other way.
TEST_F(SlowReference, IsNotTakenForLostStepsInAReversal) {
  for (const double angle_deg : {60.0, -60.0, 60.0}) {
    MoveBy("inner", angle_deg);
    WaitDelayed(6 * kSecond, 3 * kSecond / 2);
    acquisition_.ReadNow(*me_, "inner");
  }
  EXPECT_THAT(faults_, IsEmpty());
}

// Its daemon was killed, or the line was cut, while it moved.
TEST_F(AcquisitionTest, AnAxisThatMovesWhenItIsOpenedIsStoppedAndSaid) {
  MoveBy("inner", 90.0);
  devices_.drives.at("inner")->faults().FailAlways("no answer");
  Wait(2 * kSecond);
  EXPECT_THAT(notices_.List(), IsEmpty());
  devices_.drives.at("inner")->faults().Recover();
  Wait(3 * kSecond);
  const double stopped_deg = devices_.drives.at("inner")->AngleDeg();
  EXPECT_LT(stopped_deg, 80.0);
  Wait(3 * kSecond);
  EXPECT_EQ(devices_.drives.at("inner")->AngleDeg(), stopped_deg);
  ASSERT_THAT(notices_.List(), SizeIs(1));
  EXPECT_THAT(notices_.List()[0].text, HasSubstr("axis.inner"));
}

// A map of other pulses, an alarm: neither keeps it moving, nor silent.
TEST_F(AcquisitionTest, AnAxisThatMovesIsStoppedAndSaidThoughItCannotBeOpened) {
  for (const bool alarm : {false, true}) {
    drivers::FakeAxis& drive = *devices_.drives.at(alarm ? "outer" : "inner");
    MoveBy(alarm ? "outer" : "inner", 170.0);
    drive.faults().FailAlways("no answer");
    Wait(2 * kSecond);
    if (alarm) {
      drive.SetAlarm(33);
    } else {
      drive.BeAnother();
    }
    drive.faults().Recover();
    Wait(3 * kSecond);
    EXPECT_FALSE(drive.Read().moving);
    EXPECT_LT(drive.AngleDeg(), 80.0);
    ASSERT_THAT(notices_.List(), SizeIs(alarm ? 2 : 1));
    EXPECT_THAT(notices_.List().back().text, HasSubstr(alarm ? "axis.outer" : "axis.inner"));
    EXPECT_THAT(notices_.List().back().text, HasSubstr(": stopped"));
  }
}

TEST_F(AcquisitionTest, AnAxisThatMovesAndDoesNotTakeItsStopIsSaid) {
  MoveBy("inner", 90.0);
  drivers::FakeAxis& inner = *devices_.drives.at("inner");
  inner.faults().FailAlways("no answer");
  inner.on_call = [&inner](const std::string& call) {
    if (call == "stop") inner.faults().FailNext("the stop was not taken");
  };
  Wait(2 * kSecond);
  inner.faults().Recover();
  Wait(2 * kSecond);
  ASSERT_THAT(notices_.List(), Not(IsEmpty()));
  EXPECT_THAT(notices_.List()[0].text, HasSubstr("NOT stopped"));
  EXPECT_THAT(notices_.List()[0].text, HasSubstr("the stop was not taken"));
  inner.on_call = {};
}

// Each of the references costs its timeouts.
TEST_F(AcquisitionTest, EveryDriveIsAskedBeforeAnyReference) {
  std::vector<std::string> order;
  for (const DeviceStatus& device : acquisition_.Devices()) order.push_back(device.name);
  EXPECT_THAT(order, ElementsAre("relays", "axis.outer", "axis.middle", "axis.inner",
                                 "encoder.outer", "encoder.middle", "encoder.inner", "gyro"));
}

// For less than the time after which it would be silent: it was never enabled again.
TEST_F(AcquisitionTest, ADriveThatLostItsPowerForAMomentIsToldAndEnabledAgain) {
  devices_.drives.at("inner")->LosePower();
  Wait(2 * kSecond);
  EXPECT_THAT(silent_, ElementsAre("axis.inner"));
  EXPECT_TRUE(acquisition_.Axis("inner").drive.enabled);
  for (const DeviceStatus& device : acquisition_.Devices()) EXPECT_TRUE(device.ok) << device.name;
  EXPECT_EQ(MoveBy("inner", 5.0), 10.0);
}

TEST_F(AcquisitionTest, PollsNothingWhileItIsHeldAndDoesWhatIsCommanded) {
  acquisition_.Hold(*me_);
  const std::int64_t samples = acquisition_.Sensor().samples;
  Wait(kSecond);
  EXPECT_EQ(acquisition_.Sensor().samples, samples);
  acquisition_.StopAll(*me_);
  EXPECT_THAT(CallsOf("inner"), Contains("stop"));
  acquisition_.Resume();
  Wait(kSecond);
  EXPECT_GT(acquisition_.Sensor().samples, samples);
}

TEST_F(AcquisitionTest, TakesAUnitWhoseSensorIsSilentForASilentDevice) {
  devices_.gyro->Miss(1'000'000);
  Wait(5 * kSecond);
  EXPECT_THAT(silent_, Contains("gyro"));
}

TEST_F(AcquisitionTest, SwitchesOutputsThatTheStandHas) {
  ASSERT_NE(acquisition_.outputs(), nullptr);
  acquisition_.outputs()->Switch(*me_, "fan", true, [] {});
  EXPECT_TRUE(devices_.relays->on.at("fan"));
  acquisition_.outputs()->AllOff(*me_);
  EXPECT_FALSE(devices_.relays->on.at("fan"));
}

}  // namespace
}  // namespace gyrobench::daemon
