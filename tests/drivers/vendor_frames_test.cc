// The shipped register maps, number by number, as the very bytes on the wire. Frames are written
// out, checksum and all, from the vendors' tables (functions, addresses, words) by the definition
// of Modbus RTU, and share no formula with the drivers.
#include <gmock/gmock.h>

#include <memory>
#include <string>
#include <vector>

#include "config/device_maps.h"
#include "drivers/factory.h"
#include "drivers/modbus_bus.h"
#include "tests/drivers/fake_line.h"
#include "tests/drivers/manual_clock.h"

namespace gyrobench::drivers {
namespace {

using testing::ElementsAre;
using testing::IsSupersetOf;

// A drive as unit 1 and an encoder on a serial line, as their files in config/devices describe
// them.
class VendorFrames : public testing::Test {
 protected:
  VendorFrames() {
    drive_.SetHolding(0x0001, {10000});
    drive_.SetHolding(0x000F, {0});
    drive_.SetHolding(0x1003, {0x0030});
    drive_.SetHolding(0x602A, {0, 0});
    drive_.SetHolding(0x2203, {0});
    drive_.SetHolding(0x6002, {0});
    drive_.OnWrite([](std::uint16_t address, const Words&, RegisterUnit::Registers& holding) {
      if (address == 0x000F) holding[0x1003] = 0x0032;
    });
    line_.SetDelay([this](Utime duration_us) { clock_.Advance(duration_us); });
    bus_ = std::make_unique<ModbusBus>(line_.Config(), clock_, *participant_);
    axis_.name = "inner";
    axis_.drive.unit = 1;
    axis_.drive.map = config::LoadDriveMap(Map("leadshine-rs.toml"));
  }
  static std::string Map(const std::string& name) {
    return GYROBENCH_SOURCE_DIR "/config/devices/" + name;
  }
  std::unique_ptr<Axis> Drive() {
    line_.Connect(1, drive_);
    auto axis = MakeAxis(axis_, *bus_);
    axis->Open();
    return axis;
  }
  std::unique_ptr<AngleSensor> EncoderOf(const std::string& map, int unit) {
    axis_.encoder.unit = unit;
    axis_.encoder.map = config::LoadEncoderMap(Map(map));
    line_.Connect(unit, encoder_);
    return MakeAngleSensor(axis_, *bus_);
  }

  RegisterUnit drive_, encoder_;
  FakeLine line_{Transport::kRtu};
  ManualClock clock_;
  std::unique_ptr<Clock::Participant> participant_ = clock_.Join("bus", Clock::Role::kResident);
  std::unique_ptr<ModbusBus> bus_;
  config::AxisConfig axis_;
};

TEST_F(VendorFrames, OfALeadshineDriveThatIsOpened) {
  Drive();
  EXPECT_THAT(line_.requests(),
              IsSupersetOf({Bytes{0x01, 0x03, 0x00, 0x01, 0x00, 0x01, 0xD5, 0xCA},
                            Bytes{0x01, 0x03, 0x10, 0x03, 0x00, 0x01, 0x70, 0xCA},
                            Bytes{0x01, 0x03, 0x60, 0x2A, 0x00, 0x02, 0xFB, 0xC3},
                            Bytes{0x01, 0x06, 0x00, 0x0F, 0x00, 0x01, 0x78, 0x09},
                            Bytes{0x01, 0x03, 0x00, 0x0F, 0x00, 0x01, 0xB4, 0x09}}));
}

// One turn of the shaft back: -10000 pulses at 120 rpm, 750 ms per 1000 rpm up and down.
TEST_F(VendorFrames, OfALeadshineDriveThatMoves) {
  const auto axis = Drive();
  axis->MoveBy(-9.0, 18.0, 200.0);
  EXPECT_EQ(line_.requests().back(),
            (Bytes{0x01, 0x10, 0x62, 0x00, 0x00, 0x08, 0x10, 0x00, 0x41, 0xFF, 0xFF, 0xD8, 0xF0,
                   0x00, 0x78, 0x02, 0xEE, 0x02, 0xEE, 0x00, 0x00, 0x00, 0x10, 0x3C, 0x36}));
  axis->Stop();
  EXPECT_EQ(line_.requests().back(), (Bytes{0x01, 0x06, 0x60, 0x02, 0x00, 0x40, 0x37, 0xFA}));
}

TEST_F(VendorFrames, OfALeadshineDriveWhoseAlarmIsCleared) {
  const auto axis = Drive();
  const std::size_t before = line_.requests().size();
  axis->ClearAlarm();
  const std::vector<Bytes> all = line_.requests();
  EXPECT_THAT(std::vector<Bytes>(all.begin() + static_cast<std::ptrdiff_t>(before), all.end()),
              ElementsAre(Bytes{0x01, 0x06, 0x18, 0x01, 0x11, 0x11, 0x12, 0xF6},
                          Bytes{0x01, 0x03, 0x22, 0x03, 0x00, 0x01, 0x7E, 0x72}));
}

// Status words that drives were seen to give, and one with the alarm's bit.
TEST_F(VendorFrames, StatusWordsOfALeadshineDriveMeanWhatTheySay) {
  const auto axis = Drive();
  drive_.SetHolding(0x1003, {0x0006});
  AxisState state = axis->Read();
  EXPECT_TRUE(state.moving && state.enabled && !state.fault);
  drive_.SetHolding(0x1003, {0x0032});
  state = axis->Read();
  EXPECT_TRUE(!state.moving && state.enabled && !state.fault);
  drive_.SetHolding(0x1003, {0x0031});
  drive_.SetHolding(0x2203, {0x00E0});
  state = axis->Read();
  EXPECT_TRUE(state.fault && !state.enabled);
  EXPECT_EQ(state.alarm, 0x00E0);
}

// High word at the lower address: 5 turns and a quarter of the table, of 40 turns of the shaft
// each.
TEST_F(VendorFrames, PositionOfALeadshineDriveIsInPulsesOfTheShaft) {
  const auto axis = Drive();
  constexpr std::uint32_t kPulses = 2'100'000;
  drive_.SetHolding(0x602A, {kPulses >> 16, kPulses & 0xFFFF});
  EXPECT_DOUBLE_EQ(axis->Read().commanded_deg, 5.25 * 360.0);
}

TEST_F(VendorFrames, OfABriterEncoder) {
  encoder_.SetHolding(0x0000, {0x0002, 0x8000});
  const auto sensor = EncoderOf("briter-encoder.toml", 11);
  EXPECT_DOUBLE_EQ(sensor->Open().angle_deg, 360.0 * (0x28000 / 131072.0));
  EXPECT_THAT(line_.requests(), ElementsAre(Bytes{0x0B, 0x03, 0x00, 0x00, 0x00, 0x02, 0xC4, 0xA1}));
}

TEST_F(VendorFrames, OfAQy3806Encoder) {
  encoder_.SetHolding(0x0000, {0x4000});
  const auto sensor = EncoderOf("qy3806-encoder.toml", 1);
  EXPECT_DOUBLE_EQ(sensor->Open().angle_deg, 90.0);
  EXPECT_THAT(line_.requests(), ElementsAre(Bytes{0x01, 0x03, 0x00, 0x00, 0x00, 0x01, 0x84, 0x0A}));
}

}  // namespace
}  // namespace gyrobench::drivers
