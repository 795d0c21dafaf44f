// Who sent a message, in bytes behind it that no reader needs to know.
#include "recording/sender.h"

#include <gtest/gtest.h>

#include <vector>

#include "gyrobench/run_t.hpp"

namespace gyrobench::recording {
namespace {

std::vector<std::uint8_t> Encoded(const run_t& message) {
  std::vector<std::uint8_t> bytes(static_cast<std::size_t>(message.getEncodedSize()));
  message.encode(bytes.data(), 0, message.getEncodedSize());
  return bytes;
}

run_t Example() {
  run_t message{};
  message.seq = 12;
  message.record = "/records/run-1";
  return message;
}

std::vector<std::uint8_t> Signed(Sender sender) {
  std::vector<std::uint8_t> bytes = Encoded(Example());
  for (const std::uint8_t byte : BytesOf(sender)) bytes.push_back(byte);
  return bytes;
}

TEST(Sender, IsReadFromBehindAMessageAndThereWithoutOneIsNone) {
  EXPECT_EQ(SenderOf(Signed({0x0123456789abcdefU})), Sender{0x0123456789abcdefU});
  EXPECT_EQ(SenderOf(Encoded(Example())), std::nullopt);
  EXPECT_EQ(SenderOf({}), std::nullopt);
}

// Records and logs of LCM's own logger, of older daemons and of this one.
TEST(Sender, AMessageIsTheSameWithItAndWithout) {
  for (const std::vector<std::uint8_t>& bytes : {Signed({7}), Encoded(Example())}) {
    run_t read{};
    ASSERT_TRUE(DecodeSound(bytes, read));
    EXPECT_EQ(read.seq, 12);
    EXPECT_EQ(read.record, "/records/run-1");
  }
}

TEST(Sender, AnythingElseBehindAMessageIsADamage) {
  run_t read{};
  std::vector<std::uint8_t> bytes = Signed({7});
  bytes.pop_back();
  EXPECT_FALSE(DecodeSound(bytes, read));
  bytes = Signed({7});
  bytes[bytes.size() - 16] ^= 1;
  EXPECT_FALSE(DecodeSound(bytes, read));
  bytes = Signed({7});
  for (const std::uint8_t byte : BytesOf({8})) bytes.push_back(byte);
  EXPECT_FALSE(DecodeSound(bytes, read)) << "signed twice";
}

// What subscribers in other languages have: the generated code alone.
TEST(Sender, GeneratedCodeReadsTheMessageAndLeavesItAlone) {
  const std::vector<std::uint8_t> bytes = Signed({7});
  run_t read{};
  EXPECT_GE(read.decode(bytes.data(), 0, static_cast<int>(bytes.size())), 0);
  EXPECT_EQ(read.record, "/records/run-1");
}

TEST(Sender, ItsNameLeadsBackToIt) {
  for (const Sender sender : {Sender{0}, Sender{0xfedcba9876543210U}, DrawSender()}) {
    EXPECT_EQ(Name(sender).size(), 16U);
    EXPECT_EQ(SenderNamed(Name(sender)), sender);
  }
  for (const char* none : {"", "7", "000000000000000g", "00000000000000070", "-000000000000007"}) {
    EXPECT_EQ(SenderNamed(none), std::nullopt) << none;
  }
  EXPECT_NE(DrawSender(), DrawSender());
}

}  // namespace
}  // namespace gyrobench::recording
