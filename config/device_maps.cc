#include "config/device_maps.h"

#include <fmt/format.h>

#include <map>

#include "config/stand_config.h"
#include "config/toml_reader.h"
#include "config/words.h"

namespace gyrobench::config {
namespace {

constexpr IntegerRange kWord{0, 0xFFFF};
constexpr IntegerRange kBit{0, 15};
constexpr IntegerRange kPulsesPerTurn{200, 51200, "pulses"};
constexpr NumberRange kCountsPerTurn{16, 4294967296.0, "counts"};
const TomlTable::Choices<WordOrder> kWordOrders = {
    {NameOf(WordOrder::kHighFirst), WordOrder::kHighFirst},
    {NameOf(WordOrder::kLowFirst), WordOrder::kLowFirst}};
constexpr NumberRange kDelay{0, 1, "s"};
constexpr IntegerRange kRangeCounts{16, std::int64_t{1} << 32, "counts"};
// Function 03 and 04 of Modbus carry at most so many registers in one reply.
constexpr int kMaxReadWords = 125;
// MPU-6050, DLPF 0..6.
constexpr std::size_t kFilters = 7;

// A map of another kind of device would give a list of unknown keys: say what it is instead.
void CheckKind(const TomlTable& root, std::string_view kind) {
  const std::string found = root.String("kind");
  if (found != kind) {
    root.Fail("kind",
              fmt::format("expected \"{}\": this is the map of another kind of device", kind));
  }
}

std::uint16_t Word(const TomlTable& root, std::string_view key) {
  return static_cast<std::uint16_t>(root.Integer(key, kWord));
}

// The first of `words` registers or coils that must all have an address.
std::uint16_t BlockAddress(const TomlTable& root, std::string_view key, int words) {
  const std::uint16_t address = Word(root, key);
  if (address + words > 0x10000) {
    root.Fail(key, fmt::format("{} addresses from here end beyond 0xFFFF", words));
  }
  return address;
}

int Int(const TomlTable& root, std::string_view key, const IntegerRange& range) {
  return static_cast<int>(root.Integer(key, range));
}

WordOrder ReadWordOrder(const TomlTable& root) {
  return root.Choice<WordOrder>("word_order", kWordOrders);
}

// So many values has what `words` registers hold.
void CheckRange(const TomlTable& table, const EncoderMap& map) {
  const std::uint64_t most = std::uint64_t{1} << (16 * map.words);
  if (map.range_counts > most)
    table.Fail("range_counts", fmt::format("expected at most {}: words = {}", most, map.words));
}

// Two meanings on one bit: a slip of the pen that would show as a drive that never stops.
void CheckBits(const TomlTable& root, const DriveMap& map) {
  std::map<int, std::string> taken;
  for (const auto& [key, bit] : {std::pair{"fault_bit", map.fault_bit},
                                 {"enabled_bit", map.enabled_bit},
                                 {"running_bit", map.running_bit},
                                 {"command_done_bit", map.command_done_bit},
                                 {"path_done_bit", map.path_done_bit}}) {
    const auto [other, is_new] = taken.emplace(bit, key);
    if (!is_new) root.Fail(key, fmt::format("{} is bit {} already", other->second, bit));
  }
}

// Limits as the pulse count goes: + where it grows.
std::optional<DriveInputs> ReadInputs(const TomlTable& root) {
  const auto address = root.OptionalInteger("inputs_address", kWord);
  DriveInputs inputs;
  bool any = false;
  std::map<int, std::string> taken;
  for (const auto& [key, bit] : {std::pair{"emergency_stop_input_bit", &inputs.emergency_stop_bit},
                                 {"limit_plus_input_bit", &inputs.limit_plus_bit},
                                 {"limit_minus_input_bit", &inputs.limit_minus_bit}}) {
    const auto found = root.OptionalInteger(key, kBit);
    if (!found) continue;
    if (!address) root.Fail(key, "expected inputs_address as well, the register that has this bit");
    *bit = static_cast<int>(*found);
    any = true;
    const auto [other, is_new] = taken.emplace(**bit, key);
    if (!is_new) root.Fail(key, fmt::format("{} is bit {} already", other->second, **bit));
  }
  if (const auto level = root.OptionalInteger("active_input_level", {0, 1}))
    inputs.active_level = static_cast<int>(*level);
  if (!address) return std::nullopt;
  if (!any) {
    root.Fail("inputs_address",
              "expected at least one of emergency_stop_input_bit, limit_plus_input_bit and "
              "limit_minus_input_bit");
  }
  inputs.address = static_cast<std::uint16_t>(*address);
  return inputs;
}

void ReadBounds(const TomlTable& root, std::string_view min_key, std::string_view max_key,
                const IntegerRange& range, int& min, int& max) {
  min = Int(root, min_key, range);
  max = Int(root, max_key, range);
  if (min > max) root.Fail(min_key, fmt::format("expected at most {} = {}", max_key, max));
}

// One value per setting, each the meaning of one index.
void ReadTable(const TomlTable& root, std::string_view key, std::string_view value_key,
               const NumberRange& range, const NumberRange& value_range,
               std::vector<double>& settings, std::vector<double>& values) {
  settings = root.Numbers(key, range, {1, 8});
  values = root.Numbers(value_key, value_range, {1, 8});
  if (settings.size() != values.size()) {
    root.Fail(value_key,
              fmt::format("expected {} numbers, one for each of {}", settings.size(), key));
  }
}

void ReadSensor(const TomlTable& root, GyroUnitMap& map) {
  map.who_am_i = Int(root, "who_am_i", {0, 0xFF});
  ReadTable(root, "gyro_range_deg_s", "gyro_lsb_per_deg_s", {1, 1e5, "deg/s"},
            {0.01, 1e6, "LSB per deg/s"}, map.gyro_range_deg_s, map.gyro_lsb_per_deg_s);
  ReadTable(root, "accel_range_g", "accel_lsb_per_g", {0.1, 1000, "g"}, {1, 1e7, "LSB per g"},
            map.accel_range_g, map.accel_lsb_per_g);
  map.filter_bandwidth_hz =
      root.Numbers("filter_bandwidth_hz", {0.1, 1e5, "Hz"}, {kFilters, kFilters});
  map.filter_delay_s = root.Numbers("filter_delay_s", {0, 1, "s"}, {kFilters, kFilters});
  map.temperature_lsb_per_degC = root.Number("temperature_lsb_per_degC", {1, 1e5, "LSB per degC"});
  map.temperature_offset_degC = root.Number("temperature_offset_degC", {-300, 300, "degC"});
}

}  // namespace

DriveMap ReadDriveMap(const TomlTable& root) {
  CheckKind(root, "drive");
  DriveMap map;
  map.model = root.String("model");
  map.pulses_per_turn_address = Word(root, "pulses_per_turn_address");
  map.pulses_per_turn = Int(root, "pulses_per_turn", kPulsesPerTurn);
  map.enable_address = Word(root, "enable_address");
  map.status_address = Word(root, "status_address");
  map.fault_bit = Int(root, "fault_bit", kBit);
  map.enabled_bit = Int(root, "enabled_bit", kBit);
  map.running_bit = Int(root, "running_bit", kBit);
  map.command_done_bit = Int(root, "command_done_bit", kBit);
  map.path_done_bit = Int(root, "path_done_bit", kBit);
  CheckBits(root, map);
  map.position_address = BlockAddress(root, "position_address", 2);
  map.word_order = ReadWordOrder(root);
  map.alarm_address = Word(root, "alarm_address");
  map.control_address = Word(root, "control_address");
  map.clear_alarm_value = Word(root, "clear_alarm_value");
  if (const auto value = root.OptionalInteger("save_value", kWord))
    map.save_value = static_cast<std::uint16_t>(*value);
  map.trigger_address = Word(root, "trigger_address");
  map.quick_stop_value = Word(root, "quick_stop_value");
  map.path_address = BlockAddress(root, "path_address", 8);
  map.relative_mode = Word(root, "relative_mode");
  map.start_value = Word(root, "start_value");
  map.inputs = ReadInputs(root);
  ReadBounds(root, "min_rpm", "max_rpm", {1, 6000, "rpm"}, map.min_rpm, map.max_rpm);
  ReadBounds(root, "min_ramp_ms_per_1000rpm", "max_ramp_ms_per_1000rpm", {1, 65535, "ms"},
             map.min_ramp_ms_per_1000rpm, map.max_ramp_ms_per_1000rpm);
  return map;
}

EncoderMap ReadEncoderMap(const TomlTable& root) {
  CheckKind(root, "encoder");
  EncoderMap map;
  map.model = root.String("model");
  map.function = Int(root, "function", {3, 4});
  map.words = Int(root, "words", {1, 2, "registers"});
  map.address = BlockAddress(root, "address", map.words);
  map.word_order = ReadWordOrder(root);
  map.counts_per_turn = root.Number("counts_per_turn", kCountsPerTurn);
  map.range_counts = static_cast<std::uint64_t>(root.Integer("range_counts", kRangeCounts));
  CheckRange(root, map);
  map.delay_s = root.Number("delay_s", kDelay, map.delay_s);
  return map;
}

GyroUnitMap ReadGyroUnitMap(const TomlTable& root) {
  CheckKind(root, "gyro_unit");
  GyroUnitMap map;
  map.model = root.String("model");
  map.identity_address = BlockAddress(root, "identity_address", 11);
  map.magic = Word(root, "magic");
  map.protocol_version = Int(root, "protocol_version", kWord);
  map.counters_address = BlockAddress(root, "counters_address", 6);
  map.block_span = static_cast<std::uint16_t>(root.Integer("block_span", {1, 0xFFFF}));
  map.block_address = BlockAddress(root, "block_address", map.block_span);
  map.block_header_words = Int(root, "block_header_words", {8, kMaxReadWords, "words"});
  map.sample_words = Int(root, "sample_words", {8, kMaxReadWords, "words"});
  map.max_samples_per_block = Int(root, "max_samples_per_block", {1, 15, "samples"});
  const int words = map.block_header_words + map.sample_words * map.max_samples_per_block;
  if (words > kMaxReadWords) {
    root.Fail("max_samples_per_block",
              fmt::format("{} + {} * {} = {} words; a reply carries {}", map.block_header_words,
                          map.sample_words, map.max_samples_per_block, words, kMaxReadWords));
  }
  map.settings_address = BlockAddress(root, "settings_address", 4);
  map.tick_rate_hz = root.Number("tick_rate_hz", {1000, 1e9, "Hz"});
  ReadSensor(root, map);
  return map;
}

RelayMap ReadRelayMap(const TomlTable& root) {
  CheckKind(root, "relays");
  RelayMap map;
  map.model = root.String("model");
  map.channels = Int(root, "channels", {1, 32, "channels"});
  map.first_coil = BlockAddress(root, "first_coil", map.channels);
  return map;
}

void ReadOwn(const TomlTable& device, DriveMap* map) {
  if (const auto pulses = device.OptionalInteger("pulses_per_turn", kPulsesPerTurn))
    map->pulses_per_turn = static_cast<int>(*pulses);
}

void ReadOwn(const TomlTable& device, EncoderMap* map) {
  if (const auto counts = device.OptionalNumber("counts_per_turn", kCountsPerTurn))
    map->counts_per_turn = *counts;
  if (const auto range = device.OptionalInteger("range_counts", kRangeCounts)) {
    map->range_counts = static_cast<std::uint64_t>(*range);
    CheckRange(device, *map);
  }
  if (const auto delay_s = device.OptionalNumber("delay_s", kDelay)) map->delay_s = *delay_s;
  map->word_order =
      device.OptionalChoice<WordOrder>("word_order", kWordOrders).value_or(map->word_order);
}

DriveMap LoadDriveMap(const std::filesystem::path& file) {
  return TomlTable::FromFile(file).ReadWhole(ReadDriveMap);
}

EncoderMap LoadEncoderMap(const std::filesystem::path& file) {
  return TomlTable::FromFile(file).ReadWhole(ReadEncoderMap);
}

GyroUnitMap LoadGyroUnitMap(const std::filesystem::path& file) {
  return TomlTable::FromFile(file).ReadWhole(ReadGyroUnitMap);
}

RelayMap LoadRelayMap(const std::filesystem::path& file) {
  return TomlTable::FromFile(file).ReadWhole(ReadRelayMap);
}

}  // namespace gyrobench::config
