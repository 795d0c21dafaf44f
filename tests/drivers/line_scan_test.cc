// What answers on a line, as the registers say it, and what the stand file says of it.
#include "drivers/line_scan.h"

#include <gmock/gmock.h>

#include <memory>
#include <vector>

#include "base/error.h"
#include "tests/drivers/fake_line.h"
#include "tests/drivers/manual_clock.h"

namespace gyrobench::drivers {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

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
class LineScanTest : public testing::Test {
 protected:
  LineScanTest() : line_(Transport::kRtu) {
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
    gyro_.SetInput(0x0000, {0x4742, 1, 0x0102, 0, 17, 4, 0, 0, 0, 0, 0});
  }

  // At the line's own setting alone: each that is tried takes its time.
  LineReport Scan(std::vector<int> units) { return Scan(std::move(units), {{kBaud, 'N', 1}}); }
  LineReport Scan(std::vector<int> units, std::vector<LineSetting> settings) {
    return ScanLine(
        stand_, bus_, {std::move(units), std::move(settings)}, clock_, *participant_,
        [this](double fraction, const std::string&) { fractions_.push_back(fraction); });
  }

  ManualClock clock_;
  std::unique_ptr<Clock::Participant> participant_ = clock_.Join("scan", Clock::Role::kResident);
  RegisterUnit drive_, encoder_, gyro_;
  FakeLine line_;
  config::BusConfig bus_;
  config::StandConfig stand_;
  std::vector<double> fractions_;
};

TEST_F(LineScanTest, EachDeviceIsToldByItsRegisters) {
  line_.Connect(3, drive_);
  line_.Connect(13, encoder_);
  line_.Connect(21, gyro_);
  const LineReport report = Scan({1, 3, 13, 14, 21});
  ASSERT_EQ(report.found.size(), 3U);
  EXPECT_EQ(report.found[0].identity.kind, UnitKind::kDrive);
  EXPECT_EQ(report.found[0].identity.model, "model D");
  EXPECT_THAT(report.found[0].identity.says, HasSubstr("10000 pulses a turn, at pulse -2"));
  EXPECT_EQ(report.found[1].identity.kind, UnitKind::kEncoder);
  EXPECT_THAT(report.found[1].identity.says, HasSubstr("65536 counts, 180.00 deg"));
  EXPECT_EQ(report.found[2].identity.kind, UnitKind::kGyroUnit);
  EXPECT_THAT(report.found[2].identity.says, HasSubstr("serial number 17, firmware 1.2"));
  EXPECT_TRUE(report.IsAsExpected());
  EXPECT_EQ(report.asked, 5);
}

TEST_F(LineScanTest, NothingIsWritten) {
  line_.Connect(3, drive_);
  line_.Connect(13, encoder_);
  line_.Connect(21, gyro_);
  Scan({3, 13, 21, 22});
  for (const Bytes& request : line_.requests()) EXPECT_TRUE(request[1] <= 4) << int{request[1]};
}

TEST_F(LineScanTest, ADeviceInAnothersPlaceIsSaidWithWhatItIs) {
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

TEST_F(LineScanTest, ADeviceWithAnotherRateIsFoundAtThatRate) {
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

TEST_F(LineScanTest, AtRatesThatAreAskedForNoOtherIsTried) {
  line_.Connect(3, drive_, 9600);
  line_.Connect(13, encoder_, 19200);
  const LineReport report = Scan({3, 13}, {{19200, 'N', 1}, {kBaud, 'N', 1}});
  ASSERT_EQ(report.found.size(), 1U);
  EXPECT_EQ(report.found[0].unit, 13);
  ASSERT_EQ(report.missing.size(), 2U);
  EXPECT_EQ(report.missing[0].device, "axis.inner drive");
  EXPECT_EQ(report.missing[1].device, "gyro");
}

TEST_F(LineScanTest, ADeviceThatIsNowhereIsMissing) {
  line_.Connect(3, drive_);
  line_.Connect(21, gyro_);
  const LineReport report = Scan({3, 13, 21});
  ASSERT_EQ(report.missing.size(), 1U);
  EXPECT_EQ(report.missing[0].unit, 13);
  EXPECT_EQ(report.missing[0].device, "axis.inner encoder");
  EXPECT_FALSE(report.IsAsExpected());
}

TEST_F(LineScanTest, TwoDevicesOnOneNumberAreUnreadable) {
  line_.Connect(3, drive_);
  line_.Inject(LineFault::kBadChecksum, 0, 3);
  const LineReport report = Scan({3});
  ASSERT_EQ(report.found.size(), 1U);
  EXPECT_EQ(report.found[0].identity.kind, UnitKind::kUnreadable);
  EXPECT_THAT(report.found[0].identity.says, HasSubstr("checksum"));
}

TEST_F(LineScanTest, OneDisturbedReplyIsAskedForAgain) {
  line_.Connect(3, drive_);
  line_.Inject(LineFault::kBadChecksum);
  EXPECT_EQ(Scan({3}).found.at(0).identity.kind, UnitKind::kDrive);
}

TEST_F(LineScanTest, AnAdapterThatHearsItselfIsNotTakenForDevices) {
  line_.Connect(3, drive_);
  line_.Echo();
  const LineReport report = Scan({1, 2, 3, 4});
  EXPECT_TRUE(report.all_unreadable);
  EXPECT_FALSE(report.IsAsExpected());
}

TEST_F(LineScanTest, ADeviceOfNoMapIsShownByItsAnswer) {
  RegisterUnit stranger;
  line_.Connect(3, drive_);
  line_.Connect(7, stranger);
  const LineReport report = Scan({3, 7});
  ASSERT_EQ(report.found.size(), 2U);
  EXPECT_EQ(report.found[1].identity.kind, UnitKind::kUnknown);
  EXPECT_THAT(report.found[1].identity.says, HasSubstr("exception 02"));
  EXPECT_EQ(report.found[1].expected, "");
}

TEST_F(LineScanTest, ADriveThatIsSetOtherwiseSaysSo) {
  drive_.SetHolding(0x0001, {4000});
  line_.Connect(3, drive_);
  EXPECT_THAT(Scan({3}).found.at(0).identity.says, HasSubstr("4000 pulses a turn"));
  EXPECT_THAT(Scan({3}).found.at(0).identity.says, HasSubstr("expected 10000"));
}

TEST_F(LineScanTest, ProgressNeverFallsBelowZeroOrBeyondOne) {
  line_.Connect(3, drive_);
  Scan({1, 2, 3});
  ASSERT_GE(fractions_.size(), 3U);
  for (const double fraction : fractions_) {
    EXPECT_GE(fraction, 0.0);
    EXPECT_LE(fraction, 1.0);
  }
}

TEST_F(LineScanTest, ALineThatCannotBeOpenedIsAnErrorAndNotSilence) {
  bus_.device = "/dev/does-not-exist";
  EXPECT_THROW(Scan({1, 2, 3}), DeviceError);
}

}  // namespace
}  // namespace gyrobench::drivers
