// Modbus RTU on the unit's side, against frames that are made and read by the stand's own code.
#include <gtest/gtest.h>

#include <array>
#include <random>
#include <vector>

#include "stand/server/modbus.h"
#include "tests/firmware/parts.h"

namespace gyrobench::firmware {
namespace {

using Bytes = std::vector<std::uint8_t>;

class Slave : public ::testing::Test {
 protected:
  void SetUp() override { unit_init(&unit_); }

  static Bytes Framed(Bytes frame) {
    const std::uint16_t crc = stand::Crc16(frame);
    frame.push_back(static_cast<std::uint8_t>(crc & 0xFF));
    frame.push_back(static_cast<std::uint8_t>(crc >> 8));
    return frame;
  }
  // As the line brings them; without the reply's checksum, which must be right.
  Bytes Answer(const Bytes& bytes, bool sound = true) {
    receiver receiver;
    receiver_begin(&receiver);
    for (std::size_t i = 0; i < bytes.size(); ++i)
      receiver_take(&receiver, bytes[i], sound || i != 2 ? 1 : 0);
    const moment moment = {.tick = 77, .next = unit_.ring.next};
    std::array<std::uint8_t, REPLY_SIZE> reply;
    const std::uint16_t size = slave_answer(&unit_, &receiver, &moment, reply.data());
    EXPECT_LE(size, reply.size());
    if (size == 0) return {};
    EXPECT_EQ(stand::Crc16({reply.data(), size}), 0);
    return {reply.begin(), reply.begin() + size - 2};
  }
  Bytes AnswerTo(const Bytes& request) { return Answer(Framed(request)); }
  std::uint32_t rejected() const { return unit_.counters.frames_rejected; }

  unit unit_ = {};
};

TEST_F(Slave, ShowsWhoItIs) {
  unit_.boot_count = 0x1234;
  unit_.who_am_i = 0x68;
  unit_.line.serial_number = 0xA1B2C3D4;
  EXPECT_EQ(AnswerTo({21, 4, 0, 0, 0, 11}),
            (Bytes{21,   4,    22, 0x47, 0x42, 0, 1,    1,    0, 0xA1, 0xB2, 0xC3,         0xD4,
                   0x12, 0x34, 0,  0x68, 0,    3, 0xD0, 0x90, 0, 200,  0,    RING_CAPACITY}));
  EXPECT_EQ(AnswerTo({21, 4, 0, 5, 0, 1}), (Bytes{21, 4, 2, 0x12, 0x34}));
}

TEST_F(Slave, TakesSettingsOneByOneOrTogetherAndAllOrNone) {
  EXPECT_EQ(AnswerTo({21, 6, 1, 0, 0, 3}), (Bytes{21, 6, 1, 0, 0, 3}));
  EXPECT_EQ(unit_.settings.gyro_range, 3);
  EXPECT_EQ(AnswerTo({21, 16, 1, 1, 0, 2, 4, 0, 0, 0, 9}), (Bytes{21, 16, 1, 1, 0, 2}));
  EXPECT_EQ(unit_.settings.filter, 0);
  EXPECT_EQ(unit_.settings.divider, 9);
  // The last of them cannot be.
  EXPECT_EQ(AnswerTo({21, 16, 1, 0, 0, 4, 8, 0, 0, 0, 1, 0, 1, 0, 4}), (Bytes{21, 0x90, 3}));
  EXPECT_EQ(unit_.settings.gyro_range, 3);
  EXPECT_EQ(AnswerTo({21, 3, 1, 0, 0, 4}), (Bytes{21, 3, 8, 0, 3, 0, 0, 0, 9, 0, 0}));
}

TEST_F(Slave, RefusesWhatItDoesNotHaveWithItsException) {
  EXPECT_EQ(AnswerTo({21, 1, 0, 0, 0, 1}), (Bytes{21, 0x81, 1}));
  EXPECT_EQ(AnswerTo({21, 4, 0, 0, 0, 12}), (Bytes{21, 0x84, 2}));
  EXPECT_EQ(AnswerTo({21, 3, 0x41, 0, 0, 1}), (Bytes{21, 0x83, 2}));
  EXPECT_EQ(AnswerTo({21, 4, 0x40, 0, 0, 126}), (Bytes{21, 0x84, 3}));
  EXPECT_EQ(AnswerTo({21, 4, 0x40, 0, 0, 0}), (Bytes{21, 0x84, 3}));
  EXPECT_EQ(AnswerTo({21, 6, 1, 1, 0, 7}), (Bytes{21, 0x86, 3}));
  EXPECT_EQ(AnswerTo({21, 6, 0, 0, 0, 1}), (Bytes{21, 0x86, 2}));
  EXPECT_EQ(AnswerTo({21, 16, 1, 0, 0, 2, 2, 0, 0}), (Bytes{21, 0x90, 3}));
  EXPECT_EQ(rejected(), 0u);
}

TEST_F(Slave, IsSilentToDamagedFramesAndCountsThem) {
  const Bytes sound = Framed({21, 4, 0, 0, 0, 11});
  std::uint32_t expected = 0;
  for (std::size_t bit = 0; bit < 8 * sound.size(); ++bit) {
    Bytes flipped = sound;
    flipped[bit / 8] = static_cast<std::uint8_t>(flipped[bit / 8] ^ 1U << bit % 8);
    EXPECT_TRUE(Answer(flipped).empty());
    EXPECT_EQ(rejected(), ++expected);
  }
  for (std::size_t size = 1; size < sound.size(); ++size) {
    EXPECT_TRUE(Answer({sound.begin(), sound.begin() + static_cast<std::ptrdiff_t>(size)}).empty());
    EXPECT_EQ(rejected(), ++expected);
  }
  EXPECT_TRUE(Answer(sound, false).empty());
  EXPECT_EQ(rejected(), ++expected);
  // Sound by its checksum, and longer than its function says.
  EXPECT_TRUE(AnswerTo({21, 4, 0, 0, 0, 11, 0}).empty());
  EXPECT_EQ(rejected(), ++expected);
}

TEST_F(Slave, LeavesOthersAlone) {
  EXPECT_TRUE(AnswerTo({22, 4, 0, 0, 0, 11}).empty());
  Bytes reply_of_another = {3, 3, 200};
  reply_of_another.resize(203, 0x5A);
  EXPECT_TRUE(AnswerTo(reply_of_another).empty());
  EXPECT_EQ(rejected(), 0u);
}

TEST_F(Slave, DoesWhatIsSaidToAllWithoutAWord) {
  EXPECT_TRUE(AnswerTo({0, 6, 1, 0, 0, 2}).empty());
  EXPECT_EQ(unit_.settings.gyro_range, 2);
}

// Number, rate and serial number are taken together, and only with the key behind them.
TEST_F(Slave, ChangesItsLineByTheKeyAlone) {
  EXPECT_EQ(AnswerTo({21, 16, 1, 0x10, 0, 4, 8, 0, 7, 0x13, 0x88, 0, 1, 0, 2}).size(), 6u);
  EXPECT_FALSE(unit_.keep_line);
  EXPECT_EQ(AnswerTo({21, 3, 1, 0x10, 0, 5}),
            (Bytes{21, 3, 10, 0, 7, 0x13, 0x88, 0, 1, 0, 2, 0, 0}));
  EXPECT_EQ(AnswerTo({21, 6, 1, 0x14, 0x47, 0x42}).size(), 6u);
  EXPECT_TRUE(unit_.keep_line);
  EXPECT_EQ(unit_.line_wanted.unit, 7);
  EXPECT_EQ(unit_.line_wanted.serial_number, 0x00010002u);
  EXPECT_EQ(unit_.line.unit, 21);  // until the reply is through
  EXPECT_EQ(AnswerTo({21, 6, 1, 0x14, 0, 1}), (Bytes{21, 0x86, 3}));
}

TEST_F(Slave, RefusesALineOnWhichNobodyWouldFindIt) {
  for (const int hundreds : {0, 100, 2304, 2500, 20000, 65535}) {
    const auto high = static_cast<std::uint8_t>(hundreds >> 8);
    EXPECT_EQ(AnswerTo({21, 6, 1, 0x11, high, static_cast<std::uint8_t>(hundreds & 0xFF)}),
              (Bytes{21, 0x86, 3}));
  }
  for (const int number : {0, 248, 255})
    EXPECT_EQ(AnswerTo({21, 6, 1, 0x10, 0, static_cast<std::uint8_t>(number)}),
              (Bytes{21, 0x86, 3}));
  EXPECT_EQ(AnswerTo({21, 6, 1, 0x10, 1, 21}), (Bytes{21, 0x86, 3}));
}

// Whatever comes: no reply that is none, no setting that cannot be.
TEST_F(Slave, StaysInOrderWhateverComes) {
  std::mt19937 random(5);
  const auto draw = [&](int most) { return std::uniform_int_distribution(0, most)(random); };
  for (int i = 0; i < 200'000; ++i) {
    Bytes request;
    const int size = draw(30);
    for (int k = 0; k < size; ++k) request.push_back(static_cast<std::uint8_t>(draw(255)));
    if (size > 1 && draw(3) > 0) request[0] = 21;
    constexpr std::array<std::uint8_t, 4> kFunctions = {3, 4, 6, 16};
    if (size > 2 && draw(3) > 0) request[1] = kFunctions[static_cast<std::size_t>(draw(3))];
    if (size > 3 && draw(1) > 0) request[2] = static_cast<std::uint8_t>(draw(1));
    const Bytes answer = draw(3) > 0 ? AnswerTo(request) : Answer(request);
    if (!answer.empty()) {
      EXPECT_EQ(answer[0], 21);
    }
    ASSERT_LE(unit_.settings.gyro_range, 3);
    ASSERT_LE(unit_.settings.filter, 6);
    ASSERT_TRUE(line_is_possible(&unit_.line_wanted));
  }
}

}  // namespace
}  // namespace gyrobench::firmware
