// A drive is set as the stand file says, by what it says itself.
#include "drivers/drive_setting.h"

#include <gmock/gmock.h>

#include <utility>
#include <vector>

#include "base/error.h"
#include "tests/drivers/bus_bench.h"

namespace gyrobench::drivers {
namespace {

using testing::HasSubstr;

constexpr std::uint16_t kPulses = 0x0001, kStatus = 0x1003, kControl = 0x1801, kSave = 0x2211;

class DriveSettingTest : public testing::TestWithParam<Transport> {
 protected:
  DriveSettingTest() : bench_(GetParam()) {
    map_.pulses_per_turn_address = kPulses;
    map_.status_address = kStatus;
    map_.control_address = kControl;
    map_.save_value = kSave;
    drive_.SetHolding(kPulses, {4000});
    drive_.SetHolding(kStatus, {0x0032});
    drive_.SetHolding(kControl, {0});
    drive_.OnWrite([this](std::uint16_t address, const Words& values, auto&) {
      written_.emplace_back(address, values.front());
    });
  }

  Kept SetPulses() { return Set(*bench_.bus, kUnit, map_, setting_); }
  std::string Refusal() {
    try {
      SetPulses();
    } catch (const DeviceError& error) {
      return error.what();
    }
    return "";
  }

  const WrongSetting setting_ = {"pulses per turn", kPulses, 4000, 10000};
  config::DriveMap map_;
  std::vector<std::pair<std::uint16_t, std::uint16_t>> written_;
  BusBench bench_;
  RegisterUnit& drive_ = bench_.unit;
};

INSTANTIATE_TEST_SUITE_P(Transports, DriveSettingTest,
                         testing::Values(Transport::kRtu, Transport::kTcp));

TEST_P(DriveSettingTest, IsWrittenAndThenSavedAndNothingElseIs) {
  EXPECT_EQ(SetPulses(), Kept::kAlways);
  EXPECT_EQ(drive_.Holding(kPulses), 10000);
  EXPECT_EQ(written_, (decltype(written_){{kPulses, 10000}, {kControl, kSave}}));
}

TEST_P(DriveSettingTest, IsKeptUntilThePowerGoesWhereNothingSavesIt) {
  map_.save_value.reset();
  EXPECT_EQ(SetPulses(), Kept::kUntilPowerOff);
  EXPECT_EQ(written_, (decltype(written_){{kPulses, 10000}}));
}

TEST_P(DriveSettingTest, IsNotWrittenWhileTheDriveTurns) {
  drive_.SetHolding(kStatus, {0x0006});
  EXPECT_THAT(Refusal(), HasSubstr("axis.inner drive (unit 5"));
  EXPECT_THAT(Refusal(), HasSubstr("turns, by its status 0x0006"));
  EXPECT_TRUE(written_.empty());
}

TEST_P(DriveSettingTest, OfADriveThatDoesNotHoldItIsAnError) {
  drive_.OnWrite([](std::uint16_t, const Words&, RegisterUnit::Registers& holding) {
    holding[kPulses] = 4000;
  });
  EXPECT_THAT(Refusal(), HasSubstr("10000"));
}

TEST_P(DriveSettingTest, OfADriveThatTakesItBackWhenItSavesIsAnError) {
  drive_.OnWrite([](std::uint16_t address, const Words&, RegisterUnit::Registers& holding) {
    if (address == kControl) holding[kPulses] = 4000;
  });
  EXPECT_THAT(Refusal(), HasSubstr("found 4000 after they were saved"));
}

TEST_P(DriveSettingTest, ThatIsNotSavedSaysWhatTheDriveHoldsNow) {
  drive_.OnWrite([](std::uint16_t address, const Words&, RegisterUnit::Registers&) {
    if (address == kControl) throw ModbusException{3};
  });
  EXPECT_THAT(Refusal(), HasSubstr("set to 10000 pulses per turn"));
  EXPECT_THAT(Refusal(), HasSubstr("but not beyond a power-off: then it has 4000 again"));
}

}  // namespace
}  // namespace gyrobench::drivers
