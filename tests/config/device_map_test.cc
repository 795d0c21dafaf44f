#include <gmock/gmock.h>

#include "config/device_maps.h"
#include "tests/config/config_files.h"

namespace gyrobench::config {
namespace {

using testing::AllOf;
using testing::HasSubstr;

class DeviceMaps : public testing::Test {
 protected:
  std::string Shipped(const std::string& name) const {
    return ReadText(ConfigFolder() / "devices" / name);
  }
  template <typename Load>
  std::string Error(Load load, const std::string& text) const {
    return ErrorOf([&] { load(folder_.Write("map.toml", text)); });
  }
  TestFolder folder_;
};

// Every field has a value of its own, so that two that were swapped would show.
TEST_F(DeviceMaps, OfADriveFillEveryFieldFromItsKey) {
  const DriveMap map = LoadDriveMap(folder_.Write("map.toml", R"(kind = "drive"
model = "m"
pulses_per_turn_address = 101
pulses_per_turn = 4000
enable_address = 102
status_address = 103
fault_bit = 9
enabled_bit = 8
running_bit = 7
command_done_bit = 6
path_done_bit = 5
position_address = 104
word_order = "low_first"
alarm_address = 105
control_address = 106
clear_alarm_value = 107
save_value = 118
trigger_address = 108
quick_stop_value = 109
path_address = 110
relative_mode = 111
start_value = 112
inputs_address = 113
emergency_stop_input_bit = 4
limit_plus_input_bit = 3
limit_minus_input_bit = 2
active_input_level = 0
min_rpm = 2
max_rpm = 1000
min_ramp_ms_per_1000rpm = 3
max_ramp_ms_per_1000rpm = 2000
)"));
  EXPECT_EQ(map.model, "m");
  EXPECT_EQ(map.pulses_per_turn_address, 101);
  EXPECT_EQ(map.pulses_per_turn, 4000);
  EXPECT_EQ(map.enable_address, 102);
  EXPECT_EQ(map.status_address, 103);
  EXPECT_EQ(map.fault_bit, 9);
  EXPECT_EQ(map.enabled_bit, 8);
  EXPECT_EQ(map.running_bit, 7);
  EXPECT_EQ(map.command_done_bit, 6);
  EXPECT_EQ(map.path_done_bit, 5);
  EXPECT_EQ(map.position_address, 104);
  EXPECT_EQ(map.word_order, WordOrder::kLowFirst);
  EXPECT_EQ(map.alarm_address, 105);
  EXPECT_EQ(map.control_address, 106);
  EXPECT_EQ(map.clear_alarm_value, 107);
  EXPECT_EQ(map.save_value, 118);
  EXPECT_EQ(map.trigger_address, 108);
  EXPECT_EQ(map.quick_stop_value, 109);
  EXPECT_EQ(map.path_address, 110);
  EXPECT_EQ(map.relative_mode, 111);
  EXPECT_EQ(map.start_value, 112);
  ASSERT_TRUE(map.inputs);
  EXPECT_EQ(map.inputs->address, 113);
  EXPECT_EQ(map.inputs->emergency_stop_bit, 4);
  EXPECT_EQ(map.inputs->limit_plus_bit, 3);
  EXPECT_EQ(map.inputs->limit_minus_bit, 2);
  EXPECT_EQ(map.inputs->active_level, 0);
  EXPECT_EQ(map.min_rpm, 2);
  EXPECT_EQ(map.max_rpm, 1000);
  EXPECT_EQ(map.min_ramp_ms_per_1000rpm, 3);
  EXPECT_EQ(map.max_ramp_ms_per_1000rpm, 2000);
}

TEST_F(DeviceMaps, OfAnEncoderFillEveryFieldFromItsKey) {
  const EncoderMap map = LoadEncoderMap(folder_.Write("map.toml", R"(kind = "encoder"
model = "e"
function = 4
address = 7
words = 2
word_order = "low_first"
counts_per_turn = 4096.5
range_counts = 4294967296
delay_s = 0.25
)"));
  EXPECT_EQ(map.model, "e");
  EXPECT_EQ(map.function, 4);
  EXPECT_EQ(map.address, 7);
  EXPECT_EQ(map.words, 2);
  EXPECT_EQ(map.word_order, WordOrder::kLowFirst);
  EXPECT_EQ(map.counts_per_turn, 4096.5);
  EXPECT_EQ(map.range_counts, 1ULL << 32);
  EXPECT_EQ(map.delay_s, 0.25);
}

TEST_F(DeviceMaps, OfAGyroUnitFillEveryFieldFromItsKey) {
  const GyroUnitMap map = LoadGyroUnitMap(folder_.Write("map.toml", R"(kind = "gyro_unit"
model = "g"
identity_address = 1
magic = 2
protocol_version = 3
counters_address = 4
block_address = 5
block_span = 6
block_header_words = 9
sample_words = 8
max_samples_per_block = 10
settings_address = 11
tick_rate_hz = 12000
who_am_i = 13
gyro_range_deg_s = [14, 15]
gyro_lsb_per_deg_s = [16, 17]
accel_range_g = [18, 19, 20]
accel_lsb_per_g = [21, 22, 23]
filter_bandwidth_hz = [31, 32, 33, 34, 35, 36, 37]
filter_delay_s = [0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 0.7]
temperature_lsb_per_degC = 24
temperature_offset_degC = 25
)"));
  EXPECT_EQ(map.model, "g");
  EXPECT_EQ(map.identity_address, 1);
  EXPECT_EQ(map.magic, 2);
  EXPECT_EQ(map.protocol_version, 3);
  EXPECT_EQ(map.counters_address, 4);
  EXPECT_EQ(map.block_address, 5);
  EXPECT_EQ(map.block_span, 6);
  EXPECT_EQ(map.block_header_words, 9);
  EXPECT_EQ(map.sample_words, 8);
  EXPECT_EQ(map.max_samples_per_block, 10);
  EXPECT_EQ(map.settings_address, 11);
  EXPECT_EQ(map.tick_rate_hz, 12000);
  EXPECT_EQ(map.who_am_i, 13);
  EXPECT_THAT(map.gyro_range_deg_s, testing::ElementsAre(14, 15));
  EXPECT_THAT(map.gyro_lsb_per_deg_s, testing::ElementsAre(16, 17));
  EXPECT_THAT(map.accel_range_g, testing::ElementsAre(18, 19, 20));
  EXPECT_THAT(map.accel_lsb_per_g, testing::ElementsAre(21, 22, 23));
  EXPECT_THAT(map.filter_bandwidth_hz, testing::ElementsAre(31, 32, 33, 34, 35, 36, 37));
  EXPECT_THAT(map.filter_delay_s, testing::ElementsAre(0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 0.7));
  EXPECT_EQ(map.temperature_lsb_per_degC, 24);
  EXPECT_EQ(map.temperature_offset_degC, 25);
}

TEST_F(DeviceMaps, OfAnotherKindOfDeviceAreRefusedAsSuch) {
  EXPECT_THAT(Error(LoadDriveMap, Shipped("briter-encoder.toml")),
              AllOf(HasSubstr("map.toml:3: kind = "), HasSubstr("another kind of device")));
  EXPECT_THAT(Error(LoadEncoderMap, Shipped("gyro-unit.toml")), HasSubstr("expected \"encoder\""));
  EXPECT_THAT(Error(LoadGyroUnitMap, Shipped("leadshine-rs.toml")),
              HasSubstr("expected \"gyro_unit\""));
}

TEST_F(DeviceMaps, RefuseTwoMeaningsOnOneStatusBit) {
  const auto text = Replace(Shipped("leadshine-rs.toml"), "", "running_bit = 2", "running_bit = 0");
  EXPECT_THAT(Error(LoadDriveMap, text), HasSubstr("running_bit = 0: fault_bit is bit 0 already"));
}

TEST_F(DeviceMaps, OfADriveHaveInputsWithTheirRegisterAndEachBitOnce) {
  const auto with = [this](const std::string& lines) {
    return Error(LoadDriveMap, Shipped("leadshine-rs.toml") + "\n" + lines);
  };
  EXPECT_THAT(with("emergency_stop_input_bit = 0"),
              HasSubstr("expected inputs_address as well, the register that has this bit"));
  EXPECT_THAT(with("inputs_address = 0x0100"), HasSubstr("expected at least one of"));
  EXPECT_THAT(with("inputs_address = 0x0100\nlimit_plus_input_bit = 1\nlimit_minus_input_bit = 1"),
              HasSubstr("limit_plus_input_bit is bit 1 already"));
  EXPECT_FALSE(LoadDriveMap(folder_.Write("map.toml", Shipped("leadshine-rs.toml"))).inputs);
}

TEST_F(DeviceMaps, RefuseARangeUpsideDown) {
  const auto text = Replace(Shipped("leadshine-rs.toml"), "", "min_rpm = 1", "min_rpm = 3001");
  EXPECT_THAT(Error(LoadDriveMap, text),
              HasSubstr("min_rpm = 3001: expected at most max_rpm = 3000"));
}

TEST_F(DeviceMaps, RefuseARangeThatTheRegistersOfAnEncoderCannotHold) {
  const auto text =
      Replace(Shipped("qy3806-encoder.toml"), "", "range_counts = 65536", "range_counts = 65537");
  EXPECT_THAT(Error(LoadEncoderMap, text),
              HasSubstr("range_counts = 65537: expected at most 65536: words = 1"));
}

TEST_F(DeviceMaps, RefuseABlockOfSamplesThatNoReplyCarries) {
  const auto text = Replace(Shipped("gyro-unit.toml"), "", "max_samples_per_block = 14",
                            "max_samples_per_block = 15");
  EXPECT_THAT(Error(LoadGyroUnitMap, text),
              HasSubstr("8 + 8 * 15 = 128 words; a reply carries 125"));
}

TEST_F(DeviceMaps, RefuseARangeWithoutItsSensitivity) {
  const auto text =
      Replace(Shipped("gyro-unit.toml"), "", "[131, 65.5, 32.8, 16.4]", "[131, 65.5]");
  EXPECT_THAT(Error(LoadGyroUnitMap, text),
              HasSubstr("expected 4 numbers, one for each of gyro_range_deg_s"));
}

TEST_F(DeviceMaps, RefuseRegistersBeyondTheLastAddress) {
  const auto text =
      Replace(Shipped("leadshine-rs.toml"), "", "path_address = 0x6200", "path_address = 0xFFF9");
  EXPECT_THAT(Error(LoadDriveMap, text), HasSubstr("8 addresses from here end beyond 0xFFFF"));
}

}  // namespace
}  // namespace gyrobench::config
