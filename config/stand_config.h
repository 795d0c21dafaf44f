// The stand file: what the bench consists of and what it may do. Plain structs with defaults; units
// are in the names. Loading checks every key, value and range (LoadStandConfig).
#pragma once

#include <cstdint>
#include <filesystem>
#include <map>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>
#include <vector>

#include "base/geometry.h"
#include "config/device_maps.h"

namespace gyrobench::config {

// A Modbus line. One thread serves one bus.
struct BusConfig {
  enum class Transport { kRtu, kTcp };
  std::string name;
  Transport transport = Transport::kRtu;
  std::string device;  // rtu: /dev/ttyUSB0
  int baud = 115200;   // rtu; only rates that libmodbus sets truly
  char parity = 'N';   // N, E, O
  int stop_bits = 1;   // 1, 2
  std::string host;    // tcp
  int port = 502;      // tcp
  double response_timeout_s = 0.1;
  int retries = 2;  // after the first try
};

// Of the units on a Modbus line; 0 is all of them.
inline constexpr int kFirstUnit = 1, kLastUnit = 247;

// Keys of a map may be given for one device alone: what then stands here is of the map already.
struct DriveConfig {
  std::string bus;
  int unit = 1;
  DriveMap map;
  std::filesystem::path map_file = {};
  int sign = 1;  // -1: pulses that count up turn the table left-handed about the axis
};

struct EncoderConfig {
  std::string bus;
  int unit = 1;
  EncoderMap map;
  std::filesystem::path map_file = {};
  int sign = 1;               // +1: counts grow with the right-handed table angle
  double offset_deg = 0.0;    // added to the angle
  double rate_hz = 50.0;      // polled at, while a run uses the axis
  double idle_rate_hz = 5.0;  // otherwise
};

struct AxisConfig {
  std::string name;                 // outer, middle, inner
  double gear_ratio = 40.0;         // shaft turns per table turn
  double shaft_accuracy_deg = 1.0;  // half-width, of the shaft
  double min_deg = -3600.0;         // soft limits of the table
  double max_deg = 3600.0;
  double max_rate_deg_s = 60.0;
  double max_acceleration_deg_s2 = 200.0;
  double following_error_deg = 1.0;  // reference against commanded angle, at rest
  DriveConfig drive;
  EncoderConfig encoder;
};

struct GyroConfig {
  std::string bus;
  int unit = 21;
  GyroUnitMap map;
  double range_deg_s = 250.0;                  // 250, 500, 1000, 2000
  int filter = 3;                              // DLPF 0..6
  double rate_hz = 200.0;                      // 1000 / (1 + divider)
  double accel_range_g = 2.0;                  // 2, 4, 8, 16
  std::optional<std::uint32_t> serial_number;  // refused when another answers
  // By its own thermometer; beyond, all is stopped and switched off. Operating range of the MPU-6050
  // (data sheet PS-MPU-6000A rev 3.4).
  double min_degC = -40.0;
  double max_degC = 85.0;
};

// A relay unit that switches what changes the sensor's temperature.
struct RelaysConfig {
  std::string bus;
  int unit = 1;
  RelayMap map;
  std::map<std::string, int> channels;  // of the unit, by what is switched: fan, heater
  double heater_max_degC = 60.0;  // by the gyro's thermometer; above, everything is switched off
};

struct SiteConfig {
  std::optional<double> latitude_deg;  // -90..90; without it Earth's rotation is not taken off
  double heading_deg = 0.0;            // heading of world x from north, clockwise from above
};

// The reference angle's own error, as from its certificate: the same for all axes.
struct ReferenceConfig {
  std::optional<double> scale_uncertainty;  // relative standard uncertainty of a turned angle
  std::optional<double> eccentricity_deg;   // largest amplitude of an error once a turn
  std::optional<double> alignment_deg;      // largest angle between encoder's and table's axis
};

struct LcmConfig {
  std::string url = "udpm://239.255.76.67:7667?ttl=0";
  std::string channel_prefix = "GYROBENCH";
  bool required = false;  // no multicast route: true = do not start, false = warn and go on
};

struct SafetyConfig {
  double silence_s = 1.0;  // a device that has not answered for so long has fallen silent
  // A run waits for a silent device so long, suspended; then, or at once with 0, it is a fault.
  double resume_within_s = 30.0;
  double min_free_mib = 100.0;  // of the disk with the records; with less, no run begins or goes on
};

// Simulation. Present only where the stand file has a [virtual] table.
struct VirtualConfig {
  std::filesystem::path scenario;
  std::uint64_t seed = 1;
  double pace =
      0.0;  // bench seconds per real second during a run; 0 = as fast as the machine allows
  double idle_pace = 0.0;  // between runs and while an operator is asked; 0 = time stands still
  // Where the stand writes down what really happened, for who judges a run; without it nowhere.
  std::optional<std::filesystem::path> truth;
  // The simulated stand is wired as this stand file says, whatever is said here.
  std::optional<std::filesystem::path> wired_as;
  std::map<std::string, std::string> answers;  // by question id: what the operator would answer
};

struct StandConfig {
  std::filesystem::path file;
  std::string name;
  std::vector<BusConfig> buses;
  std::vector<AxisConfig> axes;  // in the order outer, middle, inner; absent ones are left out
  GyroConfig gyro;
  std::optional<RelaysConfig> relays;
  StandGeometry geometry;  // how it differs from a perfect one
  SiteConfig site;
  ReferenceConfig reference;
  LcmConfig lcm;
  SafetyConfig safety;
  std::filesystem::path records = "records";
  std::vector<std::filesystem::path> procedure_dirs;  // searched in order for NAME.lua
  std::filesystem::path control_socket;
  unsigned control_socket_mode = 0660;
  std::optional<std::string> control_socket_owner, control_socket_group;  // the daemon's own
  // Users, and groups behind "@", who may move the stand; empty: whoever can connect.
  std::vector<std::string> control_movers;
  std::optional<VirtualConfig> virtual_stand;
};

// Reads and checks a stand file and the device maps that it names. Relative paths in the file are
// taken from the file's folder. Throws ConfigError: "stand.toml:12: axis.inner.max_rate_deg_s = -5:
// expected 0.001 .. 1000 deg/s"; an unknown key is an error that names the nearest known one.
StandConfig LoadStandConfig(const std::filesystem::path& file);

// The part that reads a table already opened, as ReadDriveMap does.
StandConfig ReadStandConfig(const TomlTable& root, const std::filesystem::path& file);

// The stand file as a record keeps it: all of the stand and of its device maps, with the keys of
// the files. Of a simulation only that it is one ("virtual": true): its truth, seed and answers
// stay out of records, so that no analysis can know them.
nlohmann::json ToJson(const StandConfig& stand);

}  // namespace gyrobench::config
