// Register maps of devices, read from TOML so that a user with the part can correct any number
// without a compiler. Sources of the numbers are in the files (config/devices/*.toml).
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

namespace gyrobench::config {

class TomlTable;

enum class WordOrder { kHighFirst, kLowFirst };

// Stepper drive with one-frame moves (Leadshine RS family). Addresses are 0-based.
// The drive's digital inputs, one bit each of one word. A bit without a number: no input has that
// function.
struct DriveInputs {
  std::uint16_t address = 0;
  std::optional<int> emergency_stop_bit, limit_plus_bit, limit_minus_bit;
  int active_level = 1;  // of a bit whose input acts
};

struct DriveMap {
  std::string model;
  std::uint16_t pulses_per_turn_address = 0;  // read at Open, must equal pulses_per_turn
  int pulses_per_turn = 10000;
  std::uint16_t enable_address = 0;
  std::uint16_t status_address = 0;
  // Bits of the status word.
  int fault_bit = 0, enabled_bit = 1, running_bit = 2, command_done_bit = 4, path_done_bit = 5;
  std::uint16_t position_address = 0;  // command position, 2 words, pulses
  WordOrder word_order = WordOrder::kHighFirst;
  std::uint16_t alarm_address = 0;
  std::uint16_t control_address = 0;  // clear alarm, save parameters
  std::uint16_t clear_alarm_value = 0x1111;
  // Keeps what its parameters are set to beyond a power-off; nullopt: nothing does that is known.
  std::optional<std::uint16_t> save_value = std::nullopt;
  std::uint16_t trigger_address = 0;  // quick stop
  std::uint16_t quick_stop_value = 0x40;
  std::uint16_t path_address =
      0;  // 8 words: mode, position, rpm, acceleration, deceleration, pause, trigger
  std::uint16_t relative_mode = 0x0041;
  std::uint16_t start_value = 0x0010;
  std::optional<DriveInputs> inputs = std::nullopt;  // nullopt: they are not read
  int min_rpm = 1, max_rpm = 3000;
  int min_ramp_ms_per_1000rpm = 1, max_ramp_ms_per_1000rpm = 32767;
};

// Absolute encoder.
struct EncoderMap {
  std::string model;
  int function = 3;  // 3 or 4
  std::uint16_t address = 0;
  int words = 1;  // 1 or 2
  WordOrder word_order = WordOrder::kHighFirst;
  double counts_per_turn = 65536;      // of the table
  std::uint64_t range_counts = 65536;  // where the value wraps; unwrapped by the driver
  double delay_s = 0.0;                // a value is the angle of so long before it is given
};

// The gyro unit (our firmware): the register table of docs/gyro-unit.md.
struct GyroUnitMap {
  std::string model;
  // Input registers (function 04).
  std::uint16_t identity_address = 0;  // block of identity_words words, see docs/gyro-unit.md
  std::uint16_t magic = 0x4742;        // 'GB'
  int protocol_version = 1;
  std::uint16_t counters_address = 0x0010;
  // Sample blocks: address = block_address + (first sample number mod block_span).
  std::uint16_t block_address = 0x4000;
  std::uint16_t block_span = 0x4000;
  int block_header_words = 8;
  int sample_words = 8;
  int max_samples_per_block = 14;
  // Holding registers (functions 03, 06, 16): gyro range, filter, rate divider, accelerometer
  // range.
  std::uint16_t settings_address = 0x0100;
  double tick_rate_hz = 250000.0;
  // Sensor facts by setting, data sheet PS-MPU-6000A rev 3.4.
  int who_am_i = 0x68;
  std::vector<double> gyro_range_deg_s;     // by range index
  std::vector<double> gyro_lsb_per_deg_s;   // by range index
  std::vector<double> accel_range_g;        // by range index
  std::vector<double> accel_lsb_per_g;      // by range index
  std::vector<double> filter_bandwidth_hz;  // by filter 0..6
  std::vector<double> filter_delay_s;       // by filter 0..6
  double temperature_lsb_per_degC = 340.0;
  double temperature_offset_degC = 36.53;
};

// Relay unit: one coil a channel (functions 01 and 05).
struct RelayMap {
  std::string model;
  std::uint16_t first_coil = 0;  // of channel 0
  int channels = 1;
};

// What a device's table of the stand file says takes the place of what its map says, each key
// optional: pulses_per_turn of a drive; counts_per_turn, range_counts, word_order and delay_s of an
// encoder.
void ReadOwn(const TomlTable& device, DriveMap* map);
void ReadOwn(const TomlTable& device, EncoderMap* map);

// Each throws ConfigError as LoadStandConfig does.
DriveMap LoadDriveMap(const std::filesystem::path& file);
EncoderMap LoadEncoderMap(const std::filesystem::path& file);
GyroUnitMap LoadGyroUnitMap(const std::filesystem::path& file);
RelayMap LoadRelayMap(const std::filesystem::path& file);

// What reads a table already opened. Apart, so that a test can ask the table afterwards which keys
// are known (docs/configuration.md is checked against them).
DriveMap ReadDriveMap(const TomlTable& root);
EncoderMap ReadEncoderMap(const TomlTable& root);
GyroUnitMap ReadGyroUnitMap(const TomlTable& root);
RelayMap ReadRelayMap(const TomlTable& root);

}  // namespace gyrobench::config
