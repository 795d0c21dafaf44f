#include <gtest/gtest.h>

#include "commission/axis_seen.h"

namespace gyrobench::commission {
namespace {

using config::WordOrder;

config::EncoderMap TwoWords() {
  config::EncoderMap map;
  map.words = 2;
  map.counts_per_turn = 131072;
  map.range_counts = 0x20000000;
  return map;
}

TEST(EncoderWords, AStepGoesTheShorterWayRoundTheRange) {
  const config::EncoderMap map = TwoWords();
  EXPECT_EQ(Step(map, WordOrder::kHighFirst, {0, 5}, {0, 9}), 4);
  EXPECT_EQ(Step(map, WordOrder::kHighFirst, {0, 5}, {0x1FFF, 0xFFFF}), -6);
  EXPECT_EQ(Step(map, WordOrder::kHighFirst, {0x1FFF, 0xFFFF}, {0, 5}), 6);
}

TEST(EncoderWords, InTheOtherOrderTheSecondRegisterIsTheHighOne) {
  const config::EncoderMap map = TwoWords();
  EXPECT_EQ(Step(map, WordOrder::kLowFirst, {5, 0}, {9, 0}), 4);
  EXPECT_EQ(Step(map, WordOrder::kLowFirst, {0xFFFF, 0}, {1, 1}), 2);
  // As it is not, its low word is worth 65536 of its counts.
  EXPECT_EQ(Step(map, WordOrder::kHighFirst, {5, 0}, {9, 0}), 4 * 65536);
}

TEST(EncoderWords, OneRegisterHasNoOrder) {
  config::EncoderMap map;
  map.words = 1;
  map.range_counts = 4096;
  EXPECT_EQ(Step(map, WordOrder::kLowFirst, {4090, 0}, {4, 0}), 10);
}

// A gyro that is 3 % off must not make 127000 of 131072.
TEST(EncoderWords, CountsNearAUsualNumberAreThatOne) {
  for (const double counts : {4096.0, 8192.0, 131072.0, 20000.0, 36000.0, 7200.0}) {
    EXPECT_EQ(LikelyCounts(0.97 * counts), counts);
    EXPECT_EQ(LikelyCounts(1.03 * counts), counts);
  }
}

TEST(EncoderWords, CountsBetweenUsualNumbersOrNearNoneAreNotGuessed) {
  EXPECT_EQ(LikelyCounts(3000.0), std::nullopt);
  EXPECT_EQ(LikelyCounts(256000.0), std::nullopt);  // 250000 or 262144
}

TEST(EncoderWords, TheRangeKeepsItsTurns) {
  config::EncoderMap map = TwoWords();
  EXPECT_EQ(RangeWith(map, 8192), 0x2000000u);
  // No more than two registers hold.
  EXPECT_EQ(RangeWith(map, 1 << 26), std::uint64_t{1} << 32);
}

}  // namespace
}  // namespace gyrobench::commission
