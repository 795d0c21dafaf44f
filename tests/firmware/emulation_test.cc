// The image that is flashed, in an emulated ATmega328P with a virtual sensor on its bus.
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <vector>

#include "tests/firmware/emulation/reading.h"
#include "tests/firmware/emulation/unit_master.h"

namespace gyrobench::firmware {
namespace {

constexpr const char* kImage = GYROBENCH_FIRMWARE_IMAGE;

void ExpectNothingInvented(const ReadingCounts& counts) {
  EXPECT_EQ(counts.repeated, 0);
  EXPECT_EQ(counts.wrong, 0);
}

void ExpectAllOnce(const ReadingCounts& counts, double expected_samples) {
  EXPECT_NEAR(static_cast<double>(counts.taken), expected_samples, 0.01 * expected_samples + 20.0);
  ExpectNothingInvented(counts);
  EXPECT_EQ(counts.missing, 0);
  EXPECT_EQ(counts.late, 0);
  EXPECT_EQ(counts.told_lost, 0);
  EXPECT_EQ(counts.sensor_errors, 0);
}

TEST(Firmware, LosesNoSampleAtTheRatesThatItsLinesCarry) {
  const ReadingCounts slow = ReadFor(kImage, {.divider = 4, .baud = 115200, .duration_s = 3.0});
  ExpectAllOnce(slow, 600.0);
  EXPECT_EQ(slow.unanswered, 0);
  const ReadingCounts quick =
      ReadFor(kImage, {.divider = 0, .baud = 500000, .duration_s = 2.0, .poll_s = 0.01});
  ExpectAllOnce(quick, 2000.0);
  EXPECT_EQ(quick.unanswered, 0);
}

// The sensor samples at 8 kHz there, and its pulses are counted.
TEST(Firmware, TakesEveryFewSamplesWithoutTheSensorsFilter) {
  ExpectAllOnce(ReadFor(kImage, {.divider = 9, .filter = 0, .duration_s = 2.0}), 200.0);
}

TEST(Firmware, LosesNothingToDamagedFrames) {
  const ReadingCounts counts = ReadFor(kImage, {.duration_s = 4.0, .damaged = 0.2, .seed = 3});
  EXPECT_GT(counts.unanswered, 5);
  EXPECT_GT(counts.frames_rejected, 2);
  ExpectAllOnce(counts, 800.0);
}

TEST(Firmware, ShowsEachRestartByItsBootCounter) {
  const ReadingCounts counts = ReadFor(kImage, {.duration_s = 6.0, .resets = 3, .seed = 4});
  EXPECT_EQ(counts.restarts_seen, 3);
  ExpectNothingInvented(counts);
}

TEST(Firmware, FreesABusThatTheSensorHoldsAndGoesOn) {
  const ReadingCounts counts = ReadFor(kImage, {.duration_s = 5.0, .stuck = 2, .seed = 5});
  EXPECT_GE(counts.sensor_errors, 2);
  EXPECT_GT(counts.taken, 600);
  EXPECT_EQ(counts.missing, 0);
  ExpectNothingInvented(counts);
}

// What is off in the resonator is in the ticks, and in nothing else.
TEST(Firmware, CountsTicksOfItsOwnClock) {
  const ReadingCounts counts =
      ReadFor(kImage, {.duration_s = 3.0, .sensor_clock_rel = -0.01, .resonator_rel = 0.0025});
  EXPECT_NEAR(counts.tick_rate_rel, 0.0025, 1e-5);
  ExpectAllOnce(counts, 594.0);
}

TEST(Firmware, LeavesRoomForItsStack) {
  EXPECT_GE(ReadFor(kImage, {.divider = 0,
                             .baud = 500000,
                             .duration_s = 1.0,
                             .poll_s = 0.005,
                             .damaged = 0.05,
                             .stuck = 1})
                .stack_left,
            128u);
}

class Emulated : public ::testing::Test {
 protected:
  static VirtualMpu6050::Words Still(double, const VirtualMpu6050::Settings&) { return {}; }

  VirtualMpu6050 sensor_{Still};
  EmulatedUnit unit_{kImage, sensor_};
  UnitMaster master_{unit_};

  int BootCount() {
    const auto reply = master_.Read(4, 5, 1);
    return reply ? reply->words[0] : -1;
  }
};

TEST_F(Emulated, SetsTheSensorAsItIsAsked) {
  unit_.RunUntil(0.3);
  const std::array<std::uint16_t, 4> settings = {2, 5, 19, 3};
  ASSERT_TRUE(master_.WriteMany(0x0100, settings));
  unit_.RunUntil(0.5);
  const VirtualMpu6050::Settings found = sensor_.settings();
  EXPECT_EQ(found.gyro_range, 2);
  EXPECT_EQ(found.filter, 5);
  EXPECT_EQ(found.accel_range, 3);
  EXPECT_NEAR(found.rate_hz, 50.0, 1e-9);
}

// The driver takes the host's time of the request for that of the tick: within a tick and the time
// of an interrupt.
TEST_F(Emulated, StampsARequestWhenItIsComplete) {
  unit_.RunUntil(0.3);
  const auto first = master_.Read(4, 0x4000, 8);
  const double first_s = master_.request_complete_s();
  unit_.RunUntil(0.4137);
  const auto second = master_.Read(4, 0x4000, 8);
  ASSERT_TRUE(first && second);
  const auto tick = [](const UnitMaster::Reply& reply) {
    return static_cast<double>(reply.words[0]) * 65536.0 + reply.words[1];
  };
  EXPECT_NEAR(tick(*second) - tick(*first), 250e3 * (master_.request_complete_s() - first_s), 2.0);
}

TEST_F(Emulated, BootCounterAndLineAreThereAfterAReset) {
  unit_.RunUntil(0.2);
  EXPECT_EQ(BootCount(), 1);
  const std::array<std::uint16_t, 5> line = {33, 5000, 0x0102, 0x0304, 0x4742};
  ASSERT_TRUE(master_.WriteMany(0x0110, line));
  unit_.RunUntil(0.4);
  EXPECT_EQ(BootCount(), -1);
  UnitMaster quick(unit_, 500000, 33);
  ASSERT_TRUE(quick.Read(4, 5, 1));
  unit_.Reset();
  unit_.RunUntil(0.7);
  const auto identity = quick.Read(4, 3, 3);
  ASSERT_TRUE(identity);
  EXPECT_EQ(identity->words, (std::vector<std::uint16_t>{0x0102, 0x0304, 2}));
  // A line that nobody knows any more.
  unit_.SetDefaultsPin(true);
  unit_.Reset();
  unit_.SetDefaultsPin(true);
  unit_.RunUntil(1.0);
  EXPECT_EQ(BootCount(), 3);
}

TEST_F(Emulated, SaysThatNoSensorAnswersAndTakesOneThatComes) {
  sensor_.SetPresent(false);
  unit_.RunUntil(0.6);
  const auto who = master_.Read(4, 6, 1);
  const auto errors = master_.Read(4, 0x0012, 2);
  ASSERT_TRUE(who && errors);
  EXPECT_EQ(who->words[0], 0);
  EXPECT_GT(errors->words[1], 2);
  sensor_.SetPresent(true);
  unit_.RunUntil(1.2);
  const auto now = master_.Read(4, 6, 1);
  const auto block = master_.Read(4, 0x4000, 8);
  ASSERT_TRUE(now && block);
  EXPECT_EQ(now->words[0], 0x68);
  EXPECT_GT(block->words[3], 20);
}

TEST_F(Emulated, ShowsAnotherSensorForWhatItIs) {
  sensor_.SetWhoAmI(0x70);
  unit_.RunUntil(0.4);
  const auto who = master_.Read(4, 6, 1);
  ASSERT_TRUE(who);
  EXPECT_EQ(who->words[0], 0x70);
}

TEST_F(Emulated, LetsGoOfTheLineAfterEachReply) {
  unit_.RunUntil(0.3);
  for (int i = 0; i < 5; ++i) {
    ASSERT_TRUE(master_.Read(4, 0x4000, 24));
    EXPECT_FALSE(unit_.sends());
  }
}

}  // namespace
}  // namespace gyrobench::firmware
