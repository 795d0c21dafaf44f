// What stops all axes, with fakes of the devices: alarms, limits, inputs, ranges, a table that does
// not follow.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>

#include "daemon/bench_facts.h"
#include "tests/daemon/acquisition_fixture.h"

namespace gyrobench::daemon {
namespace {

using ::testing::Contains;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::Not;
using ::testing::SizeIs;

class AcquisitionTrips : public AcquisitionTest {};

TEST_F(AcquisitionTrips, TellsOfADrivesAlarm) {
  devices_.drives.at("inner")->SetAlarm(0x21);
  Wait(kSecond);
  ASSERT_THAT(faults_, Not(IsEmpty()));
  EXPECT_THAT(faults_[0], HasSubstr("axis.inner: the drive reports alarm 33 (0x21)"));
  acquisition_.PostClearAlarms();
  Wait(kSecond);
  EXPECT_FALSE(acquisition_.Axis("inner").drive.fault);
}

TEST_F(AcquisitionTrips, StopsEveryAxisWhereTheTableIsBeyondItsLimits) {
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

TEST_F(AcquisitionTrips, AnEmergencyStopOfOneDriveStopsAllAxesForAsLongAsItActs) {
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
  EXPECT_THAT(HowItIs(acquisition_),
              Contains("axis.inner: at 0.000 deg, its drive answers, and is not as it has to be"));
  devices_.drives.at("inner")->SetInputs(false, false, false);
  Wait(5 * kSecond);
  EXPECT_EQ(times(), 1);
  EXPECT_TRUE(drive().ok);
}

TEST_F(AcquisitionTrips, ALimitThatIsReachedIsAFaultOnceSoThatTheAxisCanBeTurnedAway) {
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

TEST_F(AcquisitionTrips, AFaultHasTheFieldsAndTheSamplesUpToIt) {
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

TEST_F(AcquisitionTrips, ATableThatMovesWithoutACommandIsAFaultAndAllIsStopped) {
  Wait(5 * kSecond);
  devices_.off_deg["middle"] = 3.0;
  Wait(3 * kSecond);
  ASSERT_THAT(faults_, SizeIs(1));
  EXPECT_THAT(faults_[0], HasSubstr("axis.middle: the table moves though nobody commanded it"));
  EXPECT_THAT(faults_[0], HasSubstr("deg from where it came to rest"));
  for (const char* axis : {"outer", "middle", "inner"})
    EXPECT_THAT(CallsOf(axis), Contains("stop")) << axis;
}

TEST_F(AcquisitionTrips, ASensorOutsideItsRangeIsAFaultAndOutputsAreOff) {
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

}  // namespace
}  // namespace gyrobench::daemon
