// What the EEPROM keeps, whenever the power goes.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cstdint>

#include "tests/firmware/parts.h"

namespace {

// The EEPROM of this process: the firmware's parts know one.
std::array<std::uint8_t, 1024> memory;
std::array<int, 1024> writes;
int writes_left = 0;  // until the power goes

}  // namespace

extern "C" {
std::uint8_t eeprom_byte(std::uint16_t address) { return memory.at(address); }
void eeprom_begin_write(std::uint16_t address, std::uint8_t byte) {
  if (writes_left == 0) return;
  // The last one is cut off: an erased byte stays behind.
  memory.at(address) = --writes_left == 0 ? 0xFF : byte;
  ++writes.at(address);
}
std::uint8_t eeprom_is_writing(void) { return 0; }
}

namespace gyrobench::firmware {
namespace {

constexpr int kMany = 1'000'000;

class Store : public ::testing::Test {
 protected:
  void SetUp() override {
    memory.fill(0xFF);
    writes.fill(0);
    writes_left = kMany;
  }
  // A start; returns the unit once all is written, or the power gone.
  static unit Start() {
    unit out;
    unit_init(&out);
    store_begin(&out);
    for (int i = 0; i < 100; ++i) store_step();
    return out;
  }
  static void Keep(const line& line) {
    store_keep_line(&line);
    for (int i = 0; i < 100; ++i) store_step();
  }
};

TEST_F(Store, NumbersTheStartsFromOneOnAndSpreadsTheWear) {
  for (int start = 1; start <= 1000; ++start) ASSERT_EQ(Start().boot_count, start);
  // Of each record one byte is written twice.
  EXPECT_LE(*std::ranges::max_element(writes), 2 * (1000 / 64 + 1));
}

TEST_F(Store, NumbersGoOnOverTheEndOf16Bits) {
  std::uint16_t before = Start().boot_count;
  for (int start = 0; start < 70'000; ++start) {
    const std::uint16_t now = Start().boot_count;
    ASSERT_EQ(now, static_cast<std::uint16_t>(before + 1));
    before = now;
  }
}

// A loss of power while a start is being noted may lose that one; the next is another number than
// the last that was noted, and none comes twice after it.
TEST_F(Store, NeverGivesANumberTwiceToStartsThatWereNoted) {
  for (int cut = 1; cut < 4; ++cut) {
    SetUp();
    for (int i = 0; i < 70; ++i) Start();
    writes_left = cut;
    const std::uint16_t cut_off = Start().boot_count;
    writes_left = kMany;
    const std::uint16_t next = Start().boot_count;
    EXPECT_GE(next, cut_off);
    EXPECT_EQ(Start().boot_count, next + 1);
  }
}

TEST_F(Store, KeepsTheLine) {
  EXPECT_EQ(Start().line.unit, 21);
  EXPECT_EQ(Start().line.baud_hundreds, 1152);
  Keep({.unit = 7, .baud_hundreds = 5000, .serial_number = 0xDEADBEEF});
  for (int i = 0; i < 300; ++i) {
    const unit now = Start();
    ASSERT_EQ(now.line.unit, 7);
    ASSERT_EQ(now.line.baud_hundreds, 5000);
    ASSERT_EQ(now.line.serial_number, 0xDEADBEEF);
  }
}

TEST_F(Store, HasTheOldLineOrTheNewOneWheneverThePowerGoes) {
  for (int before = 0; before < 300; ++before) {
    SetUp();
    Start();
    // Sequence numbers wrap as well.
    for (int i = 0; i <= before; ++i) Keep({.unit = 5, .baud_hundreds = 96, .serial_number = 1});
    for (int cut = 1; cut <= 9; ++cut) {
      writes_left = cut;
      Keep({.unit = 6, .baud_hundreds = 10000, .serial_number = 2});
      writes_left = kMany;
      const line after = Start().line;
      ASSERT_TRUE((after.unit == 5 && after.baud_hundreds == 96 && after.serial_number == 1) ||
                  (after.unit == 6 && after.baud_hundreds == 10000 && after.serial_number == 2));
      Keep({.unit = 5, .baud_hundreds = 96, .serial_number = 1});
    }
  }
}

}  // namespace
}  // namespace gyrobench::firmware
