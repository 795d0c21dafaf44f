#include "drivers/encoder.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <array>
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

class EncoderTest : public testing::Test {
 protected:
  EncoderTest() { line_.Connect(13, unit_); }
  // 17 bits a turn, 12 bits of turns, in two registers.
  static config::AxisConfig MultiTurn() {
    config::AxisConfig axis;
    axis.name = "inner";
    axis.encoder.unit = 13;
    axis.encoder.map = {.model = "encoder of the test",
                        .words = 2,
                        .counts_per_turn = 131072,
                        .range_counts = std::uint64_t{1} << 29};
    return axis;
  }
  static config::AxisConfig SingleTurn() {
    config::AxisConfig axis = MultiTurn();
    axis.encoder.map.words = 1;
    axis.encoder.map.counts_per_turn = 65536;
    axis.encoder.map.range_counts = 65536;
    return axis;
  }
  AngleReading ReadAt(AngleSensor& sensor, std::uint16_t first, std::uint16_t second = 0) {
    unit_.SetHolding(0, {first, second});
    return sensor.Read();
  }

  bool hurries_ = false;
  RegisterUnit unit_;
  FakeLine line_{Transport::kTcp};
  ManualClock clock_;
  std::unique_ptr<Clock::Participant> participant_ = clock_.Join("bus", Clock::Role::kResident);
  ModbusBus bus_{line_.Config(), clock_, *participant_, [this] { return hurries_; }};
};

TEST_F(EncoderTest, PutsWordsTogetherInTheOrderOfTheMap) {
  config::AxisConfig axis = MultiTurn();
  const auto high_first = MakeAngleSensor(axis, bus_);
  EXPECT_EQ(ReadAt(*high_first, 0x0002, 0x0001).counts, 0x20001);
  axis.encoder.map.word_order = config::WordOrder::kLowFirst;
  const auto low_first = MakeAngleSensor(axis, bus_);
  EXPECT_EQ(ReadAt(*low_first, 0x0001, 0x0002).counts, 0x20001);
}

TEST_F(EncoderTest, ReadsTheFunctionOfTheMap) {
  config::AxisConfig axis = SingleTurn();
  axis.encoder.map.function = 4;
  axis.encoder.map.address = 7;
  unit_.SetInput(7, {1234});
  unit_.SetHolding(7, {4321});
  EXPECT_EQ(MakeAngleSensor(axis, bus_)->Read().counts, 1234);
}

TEST_F(EncoderTest, AppliesSignAndOffset) {
  config::AxisConfig axis = SingleTurn();
  axis.encoder.sign = -1;
  axis.encoder.offset_deg = 10.0;
  const auto sensor = MakeAngleSensor(axis, bus_);
  EXPECT_DOUBLE_EQ(ReadAt(*sensor, 8192).angle_deg, -45.0 + 10.0);
}

// Whatever way the table goes, the sum of what it moved is the angle.
TEST_F(EncoderTest, UnwrapsOverItsRangeInBothDirections) {
  const auto sensor = MakeAngleSensor(SingleTurn(), bus_);
  std::int64_t truth = 0;
  EXPECT_EQ(ReadAt(*sensor, 0).counts, 0);
  for (int i = 0; i < 40; ++i) {
    truth += i < 15 ? 17001 : -23003;
    const auto raw = static_cast<std::uint16_t>(truth & 0xFFFF);
    clock_.Advance(2 * kMicrosecondsPerSecond);  // by no more than the axis can turn
    const AngleReading reading = ReadAt(*sensor, raw);
    ASSERT_EQ(reading.counts, truth);
    ASSERT_DOUBLE_EQ(reading.angle_deg, static_cast<double>(truth) * 360.0 / 65536);
  }
}

TEST_F(EncoderTest, TheFirstReadingIsTheRepetitionNearestToZero) {
  config::AxisConfig axis = SingleTurn();
  for (const int sign : {1, -1}) {
    for (const double offset_deg : {0.0, 190.0, -350.0, 730.0}) {
      axis.encoder.sign = sign;
      axis.encoder.offset_deg = offset_deg;
      for (const int raw : {0, 1, 20000, 32767, 45000, 65535}) {
        const auto sensor = MakeAngleSensor(axis, bus_);
        const AngleReading reading = ReadAt(*sensor, static_cast<std::uint16_t>(raw));
        EXPECT_LE(std::fabs(reading.angle_deg), 180.0 + 1e-9);
        EXPECT_EQ((reading.counts % 65536 + 65536) % 65536, raw);
        EXPECT_NEAR(reading.angle_deg,
                    sign * static_cast<double>(reading.counts) * 360 / 65536 + offset_deg, 1e-9);
      }
    }
  }
}

TEST_F(EncoderTest, OpenBeginsAnew) {
  const auto sensor = MakeAngleSensor(SingleTurn(), bus_);
  ReadAt(*sensor, 30000);
  clock_.Advance(2 * kMicrosecondsPerSecond);
  EXPECT_EQ(ReadAt(*sensor, 60000).counts, 60000);
  sensor->Open();
  EXPECT_EQ(ReadAt(*sensor, 60000).counts, 60000 - 65536);
}

// Each of them is within the sensor's range. The steps between them, the shorter way round each,
// went once around the range, and the axis was 4096 turns off for good.
TEST_F(EncoderTest, ABurstOfWrongValuesIsNotUsedAndShiftsNothing) {
  const auto sensor = MakeAngleSensor(MultiTurn(), bus_);
  const std::int64_t truth = ReadAt(*sensor, 0x0001, 0x8000).counts;
  for (const std::uint16_t wrong :
       std::array<std::uint16_t, 6>{0x0500, 0x0A00, 0x0F00, 0x1400, 0x1900, 0x1E00}) {
    clock_.Advance(20'000);
    EXPECT_THROW(ReadAt(*sensor, wrong, 0), DeviceError) << wrong;
  }
  clock_.Advance(20'000);
  EXPECT_EQ(ReadAt(*sensor, 0x0001, 0x8000).counts, truth);
}

// The next replies are wrong.
class GlitchingUnit : public RegisterUnit {
 public:
  std::atomic<int> wrong = 0;
  Words Read(int function, std::uint16_t address, std::uint16_t count) override {
    if (wrong > 0 && wrong-- > 0) return {0x0F00, 0};
    return RegisterUnit::Read(function, address, count);
  }
};

TEST_F(EncoderTest, AWrongValueIsReadAgainAtOnce) {
  GlitchingUnit glitching;
  line_.Connect(14, glitching);
  config::AxisConfig axis = MultiTurn();
  axis.encoder.unit = 14;
  const auto sensor = MakeAngleSensor(axis, bus_);
  glitching.SetHolding(0, {0x0001, 0x8000});
  const std::int64_t truth = sensor->Read().counts;
  clock_.Advance(20'000);
  glitching.wrong = 2;
  EXPECT_EQ(sensor->Read().counts, truth);
  // But not while a stop waits for the line.
  hurries_ = true;
  clock_.Advance(20'000);
  glitching.wrong = 1;
  EXPECT_THROW(sensor->Read(), DeviceError);
  EXPECT_EQ(sensor->Read().counts, truth);
}

// Somebody turned the table while nobody looked, or wrong values stayed: what stays is believed,
// and the right repetition of a sensor whose range holds all angles is known.
TEST_F(EncoderTest, AJumpThatStaysIsBelievedInTheRightRepetition) {
  config::AxisConfig axis = MultiTurn();
  axis.min_deg = -3600;
  axis.max_deg = 3600;
  const auto sensor = MakeAngleSensor(axis, bus_);
  ReadAt(*sensor, 0x0000, 0x0000);
  const auto stay_at = [&](std::uint16_t first) {
    for (int i = 0; i < 100; ++i) {
      clock_.Advance(20'000);
      try {
        return ReadAt(*sensor, first, 0x0000).counts;
      } catch (const DeviceError& error) {
        EXPECT_THAT(error.what(), HasSubstr("faster than the axis can turn"));
      }
    }
    ADD_FAILURE() << "never believed: " << first;
    return std::int64_t{0};
  };
  stay_at(0x0A00);
  stay_at(0x1400);
  EXPECT_EQ(stay_at(0x0000), 0);
}

TEST_F(EncoderTest, AValueOutsideItsRangeIsAnError) {
  const auto sensor = MakeAngleSensor(MultiTurn(), bus_);
  try {
    ReadAt(*sensor, 0x2000, 0);
    FAIL() << "no error";
  } catch (const DeviceError& error) {
    EXPECT_THAT(error.what(), AllOf(HasSubstr("axis.inner encoder"), HasSubstr("unit 13"),
                                    HasSubstr("536870911"), HasSubstr("536870912")));
  }
}

TEST_F(EncoderTest, AMapThatCannotWorkIsRefused) {
  config::AxisConfig axis = SingleTurn();
  axis.encoder.map.range_counts = 65537;
  EXPECT_THROW(MakeAngleSensor(axis, bus_), ConfigError);
  axis = SingleTurn();
  axis.encoder.map.words = 3;
  EXPECT_THROW(MakeAngleSensor(axis, bus_), ConfigError);
  axis = SingleTurn();
  axis.encoder.map.counts_per_turn = 0;
  EXPECT_THROW(MakeAngleSensor(axis, bus_), ConfigError);
}

TEST_F(EncoderTest, TimesAreInTheirOrder) {
  line_.SetDelay([&](Utime duration_us) { clock_.Advance(duration_us); });
  line_.Inject(LineFault::kLate, 3000);
  const Utime start = clock_.Now();
  const AngleReading reading = ReadAt(*MakeAngleSensor(SingleTurn(), bus_), 0);
  EXPECT_EQ(reading.utime_request, start);
  EXPECT_EQ(reading.utime, start + 1500);
  EXPECT_EQ(reading.utime_reply, start + 3000);
}

}  // namespace
}  // namespace gyrobench::drivers
