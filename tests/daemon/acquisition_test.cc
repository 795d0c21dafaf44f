// The devices at work, with fakes of them: who is asked when, and what of it is told on.
#include "daemon/acquisition.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>

#include "base/error.h"
#include "tests/daemon/acquisition_fixture.h"

namespace gyrobench::daemon {
namespace {

using ::testing::Contains;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::Not;
using ::testing::SizeIs;

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

TEST_F(AcquisitionTest, TellsWhetherAllDevicesAreWell) {
  std::vector<bool> told;
  acquisition_.WhenWellnessChanges([&](bool all_well) { told.push_back(all_well); });
  devices_.encoders.at("outer")->faults().FailAlways("no answer");
  Wait(5 * kSecond);
  devices_.encoders.at("outer")->faults().Recover();
  Wait(5 * kSecond);
  EXPECT_THAT(told, ElementsAre(false, true));
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
