// Blocks of samples: what was taken comes out once, whatever is asked for.
#include <gtest/gtest.h>

#include <array>
#include <cstring>
#include <random>
#include <vector>

#include "tests/firmware/parts.h"

namespace gyrobench::firmware {
namespace {

class Blocks : public ::testing::Test {
 protected:
  void SetUp() override { unit_init(&unit_); }

  void Take(std::uint32_t tick) {
    std::array<std::uint8_t, 2 * SAMPLE_VALUES> bytes;
    for (std::size_t i = 0; i < bytes.size(); ++i)
      bytes[i] = static_cast<std::uint8_t>(7 * unit_.ring.next + i);
    ring_write(&unit_.ring, tick, bytes.data());
    ring_advance(&unit_.ring);
    ticks_.push_back(tick);
  }

  // The words of a block that begins with sample `number`, asked for when `moment` was.
  std::vector<std::uint16_t> Ask(std::uint32_t number, const moment& moment, int samples) {
    const auto count = static_cast<std::uint8_t>(8 + 8 * samples);
    std::vector<std::uint8_t> bytes(2u * count);
    EXPECT_EQ(unit_read_input(&unit_, &moment, static_cast<std::uint16_t>(0x4000 + number % 0x4000),
                              count, bytes.data()),
              EXCEPTION_NONE);
    std::vector<std::uint16_t> words;
    for (std::size_t i = 0; i < bytes.size(); i += 2)
      words.push_back(static_cast<std::uint16_t>(bytes[i] << 8 | bytes[i + 1]));
    return words;
  }
  moment Now() const { return {.tick = 1'000'000, .next = unit_.ring.next}; }

  unit unit_ = {};
  std::vector<std::uint32_t> ticks_;  // of all samples, by number
};

std::uint32_t Long(const std::vector<std::uint16_t>& words, std::size_t at) {
  return static_cast<std::uint32_t>(words[at]) << 16 | words[at + 1];
}

TEST_F(Blocks, BeginWithTheSampleAskedForWithTheOldestOrWithNone) {
  for (std::uint32_t taken = 0; taken < 200; ++taken) {
    const std::uint32_t oldest = taken > RING_CAPACITY ? taken - RING_CAPACITY : 0;
    for (std::uint32_t wanted = 0; wanted <= taken + 3; wanted += 3) {
      const auto words = Ask(wanted, Now(), 14);
      const std::uint32_t first = wanted > taken ? taken : std::max(wanted, oldest);
      ASSERT_EQ(words[5], first) << "taken " << taken << ", wanted " << wanted;
      EXPECT_EQ(Long(words, 2), taken);
      std::uint32_t tick = Long(words, 6);
      for (std::uint32_t i = 0; i < 14 && first + i < taken; ++i) {
        tick += words[8 + 8 * i];
        EXPECT_EQ(tick, ticks_[first + i]);
        EXPECT_EQ(words[9 + 8 * i] >> 8, (7 * (first + i)) & 0xFF);
      }
      for (std::uint32_t i = taken - first; i < 14; ++i)
        for (std::uint32_t k = 0; k < 8; ++k) EXPECT_EQ(words[8 + 8 * i + k], 0);
    }
    Take(1000 * taken);
  }
}

// The moment is that of the request; the ring goes on while the reply is made.
TEST_F(Blocks, HoldNothingThatCameAfterTheRequest) {
  for (std::uint32_t i = 0; i < 90; ++i) Take(500 * i);
  const moment before = Now();
  for (std::uint32_t i = 0; i < RING_SPARE; ++i) Take(50'000 + i);
  const auto words = Ask(0, before, 14);
  EXPECT_EQ(Long(words, 2), 90u);
  // The two that came have taken two places of the ring.
  EXPECT_EQ(words[5], 90u - RING_CAPACITY + RING_SPARE);
  EXPECT_EQ(Long(words, 6), 500u * words[5]);
  EXPECT_EQ(Ask(90, before, 14)[5], 90u);
}

TEST_F(Blocks, SayWhereTwoSamplesAreTooFarApartForTheirDifference) {
  Take(0);
  Take(0xFFFE);
  Take(0xFFFE + 0xFFFF);
  Take(3'000'000);
  const auto words = Ask(0, Now(), 4);
  EXPECT_EQ(words[8 + 8], 0xFFFE);
  EXPECT_EQ(words[8 + 16], 0xFFFF);
  EXPECT_EQ(words[8 + 24], 0xFFFF);
  EXPECT_EQ(Long(Ask(3, Now(), 1), 6), 3'000'000u);
}

TEST_F(Blocks, GoOnOverTheEndsOfTheNumbers) {
  for (const std::uint32_t next : {0x3FFEu, 0x7FFFu, 0xFFFFu, 0xFFFFFFF0u}) {
    unit_.ring.next = next;
    unit_.ring.held = 0;
    for (std::uint32_t i = 0; i < 30; ++i) {
      std::array<std::uint8_t, 14> bytes = {};
      bytes[0] = static_cast<std::uint8_t>(i);
      ring_write(&unit_.ring, 100 * i, bytes.data());
      ring_advance(&unit_.ring);
    }
    std::uint32_t wanted = next;
    std::vector<int> seen;
    for (int reads = 0; reads < 5; ++reads) {
      const auto words = Ask(wanted, Now(), 14);
      EXPECT_EQ(words[5], wanted & 0xFFFF);
      for (std::size_t i = 0; i < 14 && wanted != unit_.ring.next; ++i, ++wanted)
        seen.push_back(words[9 + 8 * i] >> 8);
    }
    ASSERT_EQ(seen.size(), 30u);
    for (int i = 0; i < 30; ++i) EXPECT_EQ(seen[static_cast<std::size_t>(i)], i);
  }
}

TEST_F(Blocks, AreEmptyAfterANewSettingAndNumbersGoOn) {
  for (std::uint32_t i = 0; i < 10; ++i) Take(100 * i);
  const std::array<std::uint8_t, 2> filter = {0, 2};
  EXPECT_EQ(unit_write(&unit_, 0x0101, 1, filter.data()), EXCEPTION_NONE);
  const auto words = Ask(3, Now(), 14);
  EXPECT_EQ(Long(words, 2), 10u);
  EXPECT_EQ(words[5], 10);
}

}  // namespace
}  // namespace gyrobench::firmware
