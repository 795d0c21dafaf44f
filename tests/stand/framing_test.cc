#include <gtest/gtest.h>

#include <random>
#include <vector>

#include "stand/server/modbus.h"

namespace gyrobench::stand {
namespace {

using Bytes = std::vector<std::uint8_t>;

Bytes WithCrc(Bytes bytes) {
  const std::uint16_t crc = Crc16(bytes);
  bytes.push_back(static_cast<std::uint8_t>(crc & 0xFF));
  bytes.push_back(static_cast<std::uint8_t>(crc >> 8));
  return bytes;
}

// The definition, bit by bit.
std::uint16_t SlowCrc(const Bytes& bytes) {
  unsigned crc = 0xFFFF;
  for (const unsigned byte : bytes) {
    crc ^= byte;
    for (int i = 0; i < 8; ++i) crc = (crc & 1) != 0 ? (crc >> 1) ^ 0xA001 : crc >> 1;
  }
  return static_cast<std::uint16_t>(crc);
}

TEST(Framing, TheChecksumIsTheStandardsAndVanishesOverAWholeFrame) {
  std::mt19937 random(1);
  for (std::size_t size = 0; size < 100; ++size) {
    Bytes bytes(size);
    for (auto& byte : bytes) byte = static_cast<std::uint8_t>(random());
    EXPECT_EQ(Crc16(bytes), SlowCrc(bytes));
    EXPECT_EQ(Crc16(WithCrc(bytes)), 0);
  }
}

TEST(Framing, ARequestThatIsNotThereYetIsWaitedFor) {
  const Bytes read = WithCrc({21, 4, 0x40, 0, 0, 120});
  const Bytes write = WithCrc({1, 16, 0x62, 0, 0, 2, 4, 1, 2, 3, 4});
  for (const Bytes& whole : {read, write}) {
    for (std::size_t size = 0; size < whole.size(); ++size) {
      EXPECT_FALSE(FirstRtuFrame({whole.data(), size})) << size;
    }
    const auto frame = FirstRtuFrame(whole);
    ASSERT_TRUE(frame && frame->sound);
    EXPECT_EQ(frame->size, whole.size());
    EXPECT_EQ(frame->unit, whole[0]);
    EXPECT_EQ(frame->pdu.size(), whole.size() - 3);
  }
}

TEST(Framing, TwoRequestsInOneReadAreTakenOneAfterTheOther) {
  const Bytes first = WithCrc({1, 3, 0, 1, 0, 1});
  Bytes both = first;
  const Bytes second = WithCrc({2, 6, 0, 1, 0, 1});
  both.insert(both.end(), second.begin(), second.end());
  const auto frame = FirstRtuFrame(both);
  ASSERT_TRUE(frame && frame->sound);
  EXPECT_EQ(frame->size, first.size());
}

TEST(Framing, ADamagedRequestIsUnsoundWhicheverByteIsDamaged) {
  const Bytes whole = WithCrc({1, 6, 0x60, 2, 0, 0x40});
  for (std::size_t i = 0; i < whole.size(); ++i) {
    if (i == 1) continue;  // another function may be longer
    Bytes damaged = whole;
    damaged[i] ^= 0x10;
    const auto frame = FirstRtuFrame(damaged);
    ASSERT_TRUE(frame);
    EXPECT_FALSE(frame->sound);
  }
}

TEST(Framing, ATcpRequestTellsItsLengthTransactionAndUnit) {
  const Bytes whole = {0x12, 0x34, 0, 0, 0, 6, 21, 4, 0, 0, 0, 11};
  for (std::size_t size = 0; size < whole.size(); ++size) {
    EXPECT_FALSE(FirstTcpFrame({whole.data(), size}));
  }
  const auto frame = FirstTcpFrame(whole);
  ASSERT_TRUE(frame && frame->sound);
  EXPECT_EQ(frame->transaction, 0x1234);
  EXPECT_EQ(frame->unit, 21);
  EXPECT_EQ(frame->pdu.size(), 5U);
  Bytes other_protocol = whole;
  other_protocol[2] = 1;
  EXPECT_FALSE(FirstTcpFrame(other_protocol)->sound);
}

}  // namespace
}  // namespace gyrobench::stand
