// What answers on a line, as the registers say it, and what the stand file says of it.
#include "drivers/line_scan.h"

#include <gmock/gmock.h>

#include <memory>
#include <vector>

#include "tests/drivers/fake_line.h"
#include "tests/drivers/manual_clock.h"

namespace gyrobench::drivers {
namespace {

using testing::ElementsAre;
using testing::Field;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::Not;

constexpr int kBaud = 115200;

config::DriveMap ADriveMap() {
  config::DriveMap map;
  map.model = "model D";
  map.pulses_per_turn_address = 0x0001;
  map.status_address = 0x1003;
  map.position_address = 0x602A;
  map.path_address = 0x6200;
  return map;
}

config::EncoderMap AnEncoderMap() {
  config::EncoderMap map;
  map.model = "model E";
  map.words = 2;
  map.counts_per_turn = 131072;
  map.range_counts = 536870912;
  return map;
}

// A line with the devices of a stand: axis.inner with drive 3 and encoder 13, gyro 21.
class LineScanTest : public testing::TestWithParam<Transport> {
 protected:
  explicit LineScanTest(Transport transport = GetParam()) : line_(transport) {
    bus_ = line_.Config();
    bus_.baud = kBaud;
    bus_.response_timeout_s = 0.02;
    line_.SetDelay([this](Utime duration_us) { clock_.Advance(duration_us); });
    stand_.buses = {bus_};
    config::AxisConfig axis;
    axis.name = "inner";
    axis.drive = {.bus = "A", .unit = 3, .map = ADriveMap()};
    axis.encoder.bus = "A";
    axis.encoder.unit = 13;
    axis.encoder.map = AnEncoderMap();
    stand_.axes = {axis};
    stand_.gyro.bus = "A";
    stand_.gyro.unit = 21;
    stand_.gyro.map.model = "model G";

    drive_.SetHolding(0x0001, {10000});
    drive_.SetHolding(0x1003, {0x0032});
    drive_.SetHolding(0x602A, {0xFFFF, 0xFFFE});
    drive_.SetHolding(0x6200, {0, 0, 0, 0, 0, 0, 0, 0});
    encoder_.SetHolding(0x0000, {0x0001, 0x0000});
    gyro_.SetInput(0x0000, {0x4742, 1, 0x0102, 0, 17, 4, 0x68, 0, 0, 0, 0});
  }

  // At the line's own setting alone: each that is tried takes its time.
  LineReport Scan(std::vector<int> units) { return Scan(std::move(units), {{kBaud, 'N', 1}}); }
  LineReport Scan(std::vector<int> units, std::vector<LineSetting> settings) {
    return ScanLine(stand_, bus_, {std::move(units), std::move(settings)}, clock_, *participant_,
                    [this](double fraction, const std::string&) {
                      fractions_.push_back(fraction);
                      return fractions_.size() <= most_asked_;
                    });
  }

  void ConnectAll() {
    line_.Connect(3, drive_);
    line_.Connect(13, encoder_);
    line_.Connect(21, gyro_);
  }

  ManualClock clock_;
  std::unique_ptr<Clock::Participant> participant_ = clock_.Join("scan", Clock::Role::kResident);
  RegisterUnit drive_, encoder_, gyro_;
  FakeLine line_;
  config::BusConfig bus_;
  config::StandConfig stand_;
  std::vector<double> fractions_;
  std::size_t most_asked_ = 1000;  // then it is stopped
};

class SerialScanTest : public LineScanTest {
 protected:
  SerialScanTest() : LineScanTest(Transport::kRtu) {}
};

TEST_P(LineScanTest, EachDeviceIsToldByItsRegisters) {
  ConnectAll();
  const LineReport report = Scan({1, 3, 13, 14, 21});
  ASSERT_EQ(report.found.size(), 3U);
  EXPECT_EQ(report.found[0].identity.kind, UnitKind::kDrive);
  EXPECT_EQ(report.found[0].identity.model, "model D");
  EXPECT_THAT(report.found[0].identity.says, HasSubstr("10000 pulses a turn, at pulse -2"));
  EXPECT_EQ(report.found[1].identity.kind, UnitKind::kEncoder);
  EXPECT_THAT(report.found[1].identity.says, HasSubstr("value 65536, 180.00 deg"));
  EXPECT_EQ(report.found[2].identity.kind, UnitKind::kGyroUnit);
  EXPECT_THAT(report.found[2].identity.says, HasSubstr("serial number 17, firmware 1.2"));
  EXPECT_TRUE(report.IsAsExpected());
  EXPECT_EQ(report.asked, 5);
}

TEST_P(LineScanTest, NothingIsWritten) {
  ConnectAll();
  Scan({3, 13, 21, 22});
  for (const Bytes& request : line_.requests()) EXPECT_TRUE(request[1] <= 4) << int{request[1]};
}

TEST_P(LineScanTest, ADeviceInAnothersPlaceIsSaidWithWhatItIs) {
  line_.Connect(3, encoder_);
  line_.Connect(13, drive_);
  line_.Connect(21, gyro_);
  const LineReport report = Scan({3, 13, 21});
  ASSERT_EQ(report.found.size(), 3U);
  EXPECT_EQ(report.found[0].expected, "axis.inner drive");
  EXPECT_EQ(report.found[0].identity.kind, UnitKind::kEncoder);
  EXPECT_FALSE(report.found[0].as_expected);
  EXPECT_FALSE(report.found[1].as_expected);
  EXPECT_TRUE(report.found[2].as_expected);
  EXPECT_FALSE(report.IsAsExpected());
}

TEST_F(SerialScanTest, ADeviceWithAnotherRateIsFoundAtThatRate) {
  line_.Connect(3, drive_, 9600);
  line_.Connect(13, encoder_, kBaud);
  line_.Connect(21, gyro_, kBaud);
  const LineReport report = Scan({3, 13, 21}, {});
  ASSERT_EQ(report.found.size(), 3U);
  EXPECT_EQ(report.found[0].unit, 3);
  EXPECT_EQ(report.found[0].setting.baud, 9600);
  EXPECT_EQ(report.found[0].identity.kind, UnitKind::kDrive);
  EXPECT_FALSE(report.found[0].as_expected);
  EXPECT_EQ(report.found[1].setting, (LineSetting{kBaud, 'N', 1}));
  EXPECT_THAT(report.missing, IsEmpty());
}

TEST_F(SerialScanTest, AtRatesThatAreAskedForNoOtherIsTried) {
  line_.Connect(3, drive_, 9600);
  line_.Connect(13, encoder_, 19200);
  const LineReport report = Scan({3, 13}, {{19200, 'N', 1}, {kBaud, 'N', 1}});
  ASSERT_EQ(report.found.size(), 1U);
  EXPECT_EQ(report.found[0].unit, 13);
  ASSERT_EQ(report.missing.size(), 1U);
  EXPECT_EQ(report.missing[0].device, "axis.inner drive");
}

TEST_F(SerialScanTest, ADeviceThatIsNowhereIsMissing) {
  line_.Connect(3, drive_);
  line_.Connect(21, gyro_);
  const LineReport report = Scan({3, 13, 21});
  ASSERT_EQ(report.missing.size(), 1U);
  EXPECT_EQ(report.missing[0].unit, 13);
  EXPECT_EQ(report.missing[0].device, "axis.inner encoder");
  EXPECT_FALSE(report.IsAsExpected());
}

// A part at the end of a USB cable, that takes any rate.
TEST_F(SerialScanTest, WhatAnswersAtItsOwnSettingIsShownAtNoOther) {
  line_.Connect(3, drive_);
  const LineReport report = Scan({3}, {{9600, 'N', 1}, {kBaud, 'N', 1}});
  ASSERT_EQ(report.found.size(), 1U);
  EXPECT_TRUE(report.found[0].as_expected);
}

TEST_P(LineScanTest, OfADeviceThatWasNotAskedNothingIsSaid) {
  ConnectAll();
  const LineReport report = Scan({3});
  EXPECT_EQ(report.found.size(), 1U);
  EXPECT_THAT(report.missing, IsEmpty());
  EXPECT_TRUE(report.IsAsExpected());
}

TEST_P(LineScanTest, TwoDevicesOnOneNumberAreUnreadable) {
  line_.Connect(3, drive_);
  line_.Inject(LineFault::kBadChecksum, 0, 6);
  const LineReport report = Scan({3});
  ASSERT_EQ(report.found.size(), 1U);
  EXPECT_EQ(report.found[0].identity.kind, UnitKind::kUnreadable);
  EXPECT_THAT(report.found[0].identity.says, HasSubstr("a reply"));
}

// Whichever of its replies it is.
TEST_P(LineScanTest, OneDisturbedOrLostReplyMakesNoOtherDevice) {
  ConnectAll();
  for (const LineFault::Kind fault : {LineFault::kBadChecksum, LineFault::kLostReply}) {
    for (int before = 0; before < 3; ++before) {
      line_.Inject(LineFault::kNone, 0, before);
      line_.Inject(fault);
      const LineReport report = Scan({3, 13, 21});
      EXPECT_TRUE(report.IsAsExpected()) << fault << " after " << before;
      EXPECT_EQ(report.found.size(), 3U);
    }
  }
}

TEST_P(LineScanTest, ADisturbanceWhereNobodyIsMakesNoDevice) {
  line_.Connect(5, drive_);
  line_.Inject(LineFault::kBadChecksum);
  line_.Inject(LineFault::kLostReply);
  EXPECT_THAT(Scan({5}).found, IsEmpty());
}

TEST_P(LineScanTest, AGatewaysWordThatNobodyIsThereIsSilence) {
  line_.Connect(7, encoder_);
  for (const int code : {10, 11}) {
    line_.Inject(LineFault::kException, code);
    EXPECT_THAT(Scan({7}).found, IsEmpty()) << code;
  }
}

TEST_F(SerialScanTest, AnAdapterThatHearsItselfIsNotTakenForDevices) {
  line_.Connect(3, drive_);
  line_.Echo();
  // The rest of an echo takes its time on a pseudo-terminal, and must be waited for.
  const auto clock = MakeSystemClock();
  const auto participant = clock->Join("scan");
  const LineReport report = ScanLine(stand_, bus_, {{1, 2, 3, 4}, {{kBaud, 'N', 1}}}, *clock,
                                     *participant, [](double, const std::string&) { return true; });
  EXPECT_TRUE(report.all_unreadable);
  EXPECT_FALSE(report.IsAsExpected());
}

TEST_P(LineScanTest, WhatWasFoundBeforeItWasStoppedIsKept) {
  ConnectAll();
  most_asked_ = 4;
  const LineReport report = Scan({1, 2, 3, 4, 5, 13, 21});
  EXPECT_TRUE(report.stopped);
  EXPECT_FALSE(report.IsAsExpected());
  EXPECT_EQ(report.asked, 4);
  ASSERT_EQ(report.found.size(), 1U);
  EXPECT_EQ(report.found[0].unit, 3);
  EXPECT_THAT(report.missing, IsEmpty());
  EXPECT_THAT(report.not_asked,
              ElementsAre(Field(&MissingUnit::unit, 13), Field(&MissingUnit::unit, 21)));
}

TEST_P(LineScanTest, ADeviceOfNoMapIsShownByItsAnswer) {
  RegisterUnit stranger;
  line_.Connect(3, drive_);
  line_.Connect(7, stranger);
  const LineReport report = Scan({3, 7});
  ASSERT_EQ(report.found.size(), 2U);
  EXPECT_EQ(report.found[1].identity.kind, UnitKind::kUnknown);
  EXPECT_THAT(report.found[1].identity.says, HasSubstr("exception 02"));
  EXPECT_EQ(report.found[1].expected, "");
}

// The daemon would refuse each.
TEST_P(LineScanTest, WhatIsSetOtherwiseIsNotAsExpected) {
  stand_.gyro.serial_number = 18;
  drive_.SetHolding(0x0001, {4000});
  encoder_.SetHolding(0x0000, {0xFFFF, 0});
  ConnectAll();
  const LineReport report = Scan({3, 13, 21});
  ASSERT_EQ(report.found.size(), 3U);
  EXPECT_THAT(report.found[0].identity.wrong,
              ElementsAre(HasSubstr("4000 pulses a turn, and 10000 are expected")));
  EXPECT_THAT(report.found[1].identity.wrong,
              ElementsAre(HasSubstr("less than 536870912 is expected")));
  EXPECT_THAT(report.found[2].identity.wrong, ElementsAre(HasSubstr("is 17, and 18 is expected")));
  for (const FoundUnit& found : report.found) EXPECT_FALSE(found.as_expected) << found.unit;
}

TEST_P(LineScanTest, AGyroUnitOfAnotherProtocolOrSensorIsNotAsExpected) {
  gyro_.SetInput(0x0000, {0x4742, 2, 0x0102, 0, 17, 4, 0x70, 0, 0, 0, 0});
  line_.Connect(21, gyro_);
  EXPECT_THAT(Scan({21}).found.at(0).identity.wrong,
              ElementsAre(HasSubstr("is 2, and 1 is expected"), HasSubstr("WHO_AM_I")));
}

// A device that does not know function 03 at all.
class InputsOnly final : public FakeUnit {
 public:
  Words Read(int function, std::uint16_t, std::uint16_t count) override {
    if (function != 4) throw ModbusException{1};
    return Words(count, 5);
  }
  void Write(std::uint16_t, const Words&) override { throw ModbusException{1}; }
};

TEST_P(LineScanTest, AnEncoderIsAskedByTheFunctionOfItsMap) {
  stand_.axes[0].encoder.map.function = 4;
  InputsOnly encoder;
  line_.Connect(13, encoder);
  const LineReport report = Scan({13});
  ASSERT_EQ(report.found.size(), 1U);
  EXPECT_EQ(report.found[0].identity.kind, UnitKind::kEncoder);
  EXPECT_TRUE(report.found[0].as_expected);
}

// So many parts have a register of that address that it says nothing of what they are.
TEST_P(LineScanTest, AStrangerWithAnEncodersRegisterIsGivenNoAngle) {
  line_.Connect(9, encoder_);
  const UnitIdentity identity = Scan({9}).found.at(0).identity;
  EXPECT_EQ(identity.kind, UnitKind::kUnknown);
  EXPECT_THAT(identity.says, HasSubstr("may be an encoder"));
  EXPECT_THAT(identity.may_be, ElementsAre(UnitKind::kEncoder));
  EXPECT_THAT(identity.says, Not(HasSubstr("deg")));
}

TEST_P(LineScanTest, EachDriveIsHeldAgainstItsOwnMap) {
  config::AxisConfig outer = stand_.axes[0];
  outer.name = "outer";
  outer.drive.unit = 1;
  outer.drive.map.model = "model D4";
  outer.drive.map.pulses_per_turn = 4000;
  outer.encoder.unit = 11;
  stand_.axes.push_back(outer);
  RegisterUnit of_4000;
  of_4000.SetHolding(0x0001, {4000});
  of_4000.SetHolding(0x1003, {0x0032});
  of_4000.SetHolding(0x602A, {0, 0});
  line_.Connect(1, of_4000);
  line_.Connect(3, drive_);
  EXPECT_TRUE(Scan({1, 3}).IsAsExpected());
  line_.Connect(1, drive_);
  line_.Connect(3, of_4000);
  const LineReport swapped = Scan({1, 3});
  EXPECT_FALSE(swapped.found.at(0).as_expected);
  EXPECT_FALSE(swapped.found.at(1).as_expected);
}

TEST_P(LineScanTest, WhoAnswersToEveryNumberIsNoCrowd) {
  for (int unit = 1; unit <= 21; ++unit) line_.Connect(unit, drive_);
  std::vector<int> units;
  for (int unit = 1; unit <= 21; ++unit) units.push_back(unit);
  EXPECT_TRUE(Scan(units).all_answer);
  EXPECT_FALSE(Scan({3}).all_answer);
}

TEST_P(LineScanTest, ProgressNeverFallsBelowZeroOrBeyondOne) {
  line_.Connect(3, drive_);
  Scan({1, 2, 3});
  ASSERT_GE(fractions_.size(), 3U);
  for (const double fraction : fractions_) {
    EXPECT_GE(fraction, 0.0);
    EXPECT_LE(fraction, 1.0);
  }
}

TEST_P(LineScanTest, ALineThatCannotBeOpenedIsAnErrorAndNotSilence) {
  line_.Unplug();
  bus_.device = "/dev/does-not-exist";
  const LineReport report = Scan({1, 2, 3});
  EXPECT_THAT(report.error, HasSubstr("cannot open"));
  EXPECT_THAT(report.missing, IsEmpty());
  EXPECT_FALSE(report.IsAsExpected());
}

INSTANTIATE_TEST_SUITE_P(OnEach, LineScanTest, testing::Values(Transport::kRtu, Transport::kTcp));

}  // namespace
}  // namespace gyrobench::drivers
