// The firmware's register numbers against the device map that the driver reads.
#include <gtest/gtest.h>

#include "config/device_maps.h"
#include "tests/firmware/parts.h"

namespace gyrobench::firmware {
namespace {

TEST(FirmwareRegisters, AreThoseOfTheDeviceMap) {
  const config::GyroUnitMap map =
      config::LoadGyroUnitMap(GYROBENCH_SOURCE_DIR "/config/devices/gyro-unit.toml");
  EXPECT_EQ(REG_IDENTITY, map.identity_address);
  EXPECT_EQ(REG_COUNTERS, map.counters_address);
  EXPECT_EQ(REG_BLOCKS, map.block_address);
  EXPECT_EQ(REG_BLOCKS_SPAN, map.block_span);
  EXPECT_EQ(REG_SETTINGS, map.settings_address);
  EXPECT_EQ(BLOCK_HEADER_WORDS, map.block_header_words);
  EXPECT_EQ(BLOCK_SAMPLE_WORDS, map.sample_words);
  EXPECT_EQ(BLOCK_MOST_SAMPLES, map.max_samples_per_block);
  EXPECT_EQ(UNIT_MAGIC, map.magic);
  EXPECT_EQ(PROTOCOL_VERSION, map.protocol_version);
  EXPECT_EQ(static_cast<double>(TICK_RATE_HZ), map.tick_rate_hz);
  EXPECT_EQ(map.gyro_range_deg_s.size(), 4u);
  EXPECT_EQ(map.filter_delay_s.size(), 7u);
}

// A block is found by the number of its first sample: what the ring holds must be told apart.
TEST(FirmwareRegisters, ABlockOfTheRingHasOneAddress) {
  EXPECT_LT(RING_SLOTS, REG_BLOCKS_SPAN / 2);
  EXPECT_EQ(RING_SLOTS & (RING_SLOTS - 1), 0);
  EXPECT_LE(2 * (BLOCK_HEADER_WORDS + BLOCK_MOST_SAMPLES * BLOCK_SAMPLE_WORDS) + 5, REPLY_SIZE);
}

}  // namespace
}  // namespace gyrobench::firmware
