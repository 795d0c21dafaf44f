#include "config/stand_config.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <string>
#include <string_view>
#include <utility>

#include "config/bus_load.h"
#include "config/drive_rates.h"
#include "config/stand_sections.h"
#include "config/toml_reader.h"

namespace gyrobench::config {
namespace fs = std::filesystem;
namespace {

constexpr std::array<std::string_view, 3> kAxisNames = {"outer", "middle", "inner"};
constexpr IntegerRange kUnit{kFirstUnit, kLastUnit};
constexpr double kMostBusLoad = 0.9;
// sun_path of a Unix socket holds 108 bytes with the closing zero.
constexpr std::size_t kMaxSocketPath = 107;

int Int(const TomlTable& table, std::string_view key, const IntegerRange& range, int fallback) {
  return static_cast<int>(table.Integer(key, range, fallback));
}

// Who answers on which bus, and that no two answer alike.
class Units {
 public:
  void ReadAddress(const TomlTable& device, const std::vector<BusConfig>& buses, std::string& bus,
                   int& unit) {
    bus = device.String("bus");
    unit = static_cast<int>(device.Integer("unit", kUnit));
    if (std::ranges::none_of(buses, [&](const BusConfig& known) { return known.name == bus; })) {
      std::vector<std::string_view> names;
      for (const BusConfig& known : buses) names.push_back(known.name);
      device.Fail("bus", fmt::format("no such bus: expected one of \"{}\" (tables [bus.NAME])",
                                     fmt::join(names, "\", \"")));
    }
    const auto [other, is_new] = taken_.emplace(std::pair(bus, unit), device.name());
    if (!is_new) {
      device.Fail("unit", fmt::format("{} is unit {} on bus \"{}\" already: each device on a bus "
                                      "needs a unit of its own",
                                      other->second, unit, bus));
    }
  }

 private:
  std::map<std::pair<std::string, int>, std::string> taken_;
};

// The map file that `key` names. Missing: an error at the line that names it.
fs::path MapFile(const TomlTable& device) {
  fs::path file = device.Path("map");
  if (!fs::is_regular_file(file)) {
    device.Fail("map", fmt::format("{}: no such file; expected the register map of a device "
                                   "(config/devices has some)",
                                   file.string()));
  }
  return file;
}

void ReadSerialLine(const TomlTable& table, BusConfig& bus) {
  bus.device = table.Path("device").string();
  const std::vector<int>& bauds = SettableBauds();
  bus.baud = Int(table, "baud", {bauds.front(), bauds.back(), "baud"}, bus.baud);
  if (std::ranges::find(bauds, bus.baud) == bauds.end()) {
    table.Fail("baud", fmt::format("expected one of {}: libmodbus would silently set 9600",
                                   fmt::join(bauds, ", ")));
  }
  bus.parity = table.Choice<char>("parity", {{"N", 'N'}, {"E", 'E'}, {"O", 'O'}}, bus.parity);
  bus.stop_bits = Int(table, "stop_bits", {1, 2, "bits"}, bus.stop_bits);
}

BusConfig ReadBus(const TomlTable& table, const std::string& name) {
  using Transport = BusConfig::Transport;
  BusConfig bus;
  bus.name = name;
  bus.transport =
      table.Choice<Transport>("transport", {{"rtu", Transport::kRtu}, {"tcp", Transport::kTcp}});
  if (bus.transport == Transport::kRtu) {
    ReadSerialLine(table, bus);
  } else {
    bus.host = table.String("host");
    bus.port = Int(table, "port", {1, 65535}, bus.port);
  }
  bus.response_timeout_s =
      table.Number("response_timeout_s", {0.001, 10, "s"}, bus.response_timeout_s);
  bus.retries = Int(table, "retries", {0, 10}, bus.retries);
  return bus;
}

std::vector<BusConfig> ReadBuses(const TomlTable& root) {
  const TomlTable tables = root.Table("bus");
  std::vector<BusConfig> buses;
  for (const std::string& name : tables.Keys()) {
    const TomlTable table = tables.Table(name);
    BusConfig bus = ReadBus(table, name);
    const bool serial = bus.transport == BusConfig::Transport::kRtu;
    for (const BusConfig& other : buses) {
      if (serial && other.device == bus.device)
        table.Fail("device",
                   fmt::format("expected a line of its own: it is that of bus {} too", other.name));
    }
    buses.push_back(std::move(bus));
  }
  if (buses.empty()) tables.FailTable("expected at least one table [bus.NAME]");
  return buses;
}

int Sign(const TomlTable& table, int fallback) {
  const int sign = Int(table, "sign", {-1, 1}, fallback);
  if (sign == 0) table.Fail("sign", "expected 1 or -1");
  return sign;
}

DriveConfig ReadDrive(const TomlTable& table, const std::vector<BusConfig>& buses, Units& units) {
  DriveConfig drive;
  units.ReadAddress(table, buses, drive.bus, drive.unit);
  drive.map_file = MapFile(table);
  drive.map = LoadDriveMap(drive.map_file);
  ReadOwn(table, &drive.map);
  drive.sign = Sign(table, drive.sign);
  return drive;
}

EncoderConfig ReadEncoder(const TomlTable& table, const std::vector<BusConfig>& buses,
                          Units& units) {
  EncoderConfig encoder;
  units.ReadAddress(table, buses, encoder.bus, encoder.unit);
  encoder.map_file = MapFile(table);
  encoder.map = LoadEncoderMap(encoder.map_file);
  ReadOwn(table, &encoder.map);
  encoder.sign = Sign(table, encoder.sign);
  encoder.offset_deg = table.Number("offset_deg", {-360, 360, "deg"}, encoder.offset_deg);
  encoder.rate_hz = table.Number("rate_hz", {0.1, 1000, "Hz"}, encoder.rate_hz);
  encoder.idle_rate_hz = table.Number("idle_rate_hz", {0.1, 1000, "Hz"}, encoder.idle_rate_hz);
  if (encoder.idle_rate_hz > encoder.rate_hz) {
    table.Fail("idle_rate_hz", fmt::format("expected at most rate_hz = {} Hz", encoder.rate_hz));
  }
  return encoder;
}

// What the drive cannot express is refused here, not at the first move.
void CheckDriveCan(const TomlTable& table, const AxisConfig& axis) {
  const DriveMap& map = axis.drive.map;
  const double min_deg_s = SlowestRate_deg_s(axis);
  const double max_deg_s = FastestRate_deg_s(axis);
  if (axis.max_rate_deg_s < min_deg_s || axis.max_rate_deg_s > max_deg_s) {
    table.Fail(
        "max_rate_deg_s",
        fmt::format("expected {:.4g} .. {:.4g} deg/s: the drive ({}) turns the shaft at {} "
                    ".. {} rpm, gear ratio {}",
                    min_deg_s, max_deg_s, map.model, map.min_rpm, map.max_rpm, axis.gear_ratio));
  }
  const double slowest_deg_s2 = SlowestAcceleration_deg_s2(axis);
  if (axis.max_acceleration_deg_s2 < slowest_deg_s2) {
    table.Fail(
        "max_acceleration_deg_s2",
        fmt::format("expected at least {:.4g} deg/s^2: the longest ramp of the drive ({}) is "
                    "{} ms per 1000 rpm, gear ratio {}",
                    slowest_deg_s2, map.model, map.max_ramp_ms_per_1000rpm, axis.gear_ratio));
  }
}

AxisConfig ReadAxis(const TomlTable& table, std::string_view name,
                    const std::vector<BusConfig>& buses, Units& units) {
  constexpr NumberRange kAngle{-360000, 360000, "deg"};
  AxisConfig axis;
  axis.name = name;
  axis.gear_ratio =
      table.Number("gear_ratio", {0.01, 10000, "shaft turns per table turn"}, axis.gear_ratio);
  axis.shaft_accuracy_deg =
      table.Number("shaft_accuracy_deg", {0, 180, "deg"}, axis.shaft_accuracy_deg);
  axis.min_deg = table.Number("min_deg", kAngle, axis.min_deg);
  axis.max_deg = table.Number("max_deg", kAngle, axis.max_deg);
  if (!(axis.min_deg < axis.max_deg)) {
    table.Fail("min_deg", fmt::format("expected less than max_deg = {} deg", axis.max_deg));
  }
  axis.max_rate_deg_s = table.Number("max_rate_deg_s", {0.001, 1000, "deg/s"}, axis.max_rate_deg_s);
  axis.max_acceleration_deg_s2 = table.Number("max_acceleration_deg_s2", {0.01, 100000, "deg/s^2"},
                                              axis.max_acceleration_deg_s2);
  axis.following_error_deg =
      table.Number("following_error_deg", {0.001, 360, "deg"}, axis.following_error_deg);
  axis.drive = ReadDrive(table.Table("drive"), buses, units);
  axis.encoder = ReadEncoder(table.Table("encoder"), buses, units);
  CheckDriveCan(table, axis);
  return axis;
}

std::vector<AxisConfig> ReadAxes(const TomlTable& root, const std::vector<BusConfig>& buses,
                                 Units& units) {
  const TomlTable tables = root.Table("axis");
  std::vector<AxisConfig> axes;
  for (const std::string_view name : kAxisNames) {
    if (const auto table = tables.OptionalTable(name)) {
      axes.push_back(ReadAxis(*table, name, buses, units));
    }
  }
  tables.Finish();  // a misspelt axis before the complaint that there is none
  if (axes.empty()) tables.FailTable("expected at least one of [axis.outer], .middle, .inner");
  for (const AxisConfig& axis : axes) {
    if (axis.encoder.map.delay_s == axes[0].encoder.map.delay_s) continue;
    tables.FailTable(fmt::format(
        "the encoders of {} and {} declare delays of {} s and {} s in their device maps; expected "
        "one delay for all encoders of a stand (leave delay_s out of both, and it is measured)",
        axes[0].name, axis.name, axes[0].encoder.map.delay_s, axis.encoder.map.delay_s));
  }
  return axes;
}

double OneOfSettings(const TomlTable& table, std::string_view key, const NumberRange& range,
                     double fallback, const std::vector<double>& settings) {
  const double value = table.Number(key, range, fallback);
  if (std::ranges::find(settings, value) == settings.end()) {
    table.Fail(key, fmt::format("expected one of {} {} (the device map)", fmt::join(settings, ", "),
                                range.unit));
  }
  return value;
}

// The sensor divides 1000 Hz by a whole number.
void CheckSampleRate(const TomlTable& table, double rate_hz) {
  const double divider = std::round(1000.0 / rate_hz);
  if (std::abs(1000.0 / divider - rate_hz) > 1e-3) {
    table.Fail("rate_hz", fmt::format("expected 1000 / (1 + d) Hz for a whole d of 0 .. 255; the "
                                      "nearest are {:.3f} and {:.3f}",
                                      1000.0 / divider,
                                      1000.0 / (divider + (1000.0 / divider > rate_hz ? 1 : -1))));
  }
}

GyroConfig ReadGyro(const TomlTable& table, const std::vector<BusConfig>& buses, Units& units) {
  GyroConfig gyro;
  units.ReadAddress(table, buses, gyro.bus, gyro.unit);
  gyro.map = LoadGyroUnitMap(MapFile(table));
  gyro.range_deg_s = OneOfSettings(table, "range_deg_s", {1, 100000, "deg/s"}, gyro.range_deg_s,
                                   gyro.map.gyro_range_deg_s);
  gyro.accel_range_g = OneOfSettings(table, "accel_range_g", {0.1, 1000, "g"}, gyro.accel_range_g,
                                     gyro.map.accel_range_g);
  gyro.filter = Int(table, "filter", {0, 6}, gyro.filter);
  gyro.rate_hz = table.Number("rate_hz", {3.906, 1000, "Hz"}, gyro.rate_hz);
  CheckSampleRate(table, gyro.rate_hz);
  gyro.min_degC = table.Number("min_degC", {-100, 150, "degC"}, gyro.min_degC);
  gyro.max_degC = table.Number("max_degC", {-100, 150, "degC"}, gyro.max_degC);
  if (gyro.max_degC <= gyro.min_degC) table.Fail("max_degC", "expected more than min_degC");
  if (const auto serial = table.OptionalInteger("serial_number", {0, 0xFFFFFFFF})) {
    gyro.serial_number = static_cast<std::uint32_t>(*serial);
  }
  return gyro;
}

RelaysConfig ReadRelays(const TomlTable& table, const std::vector<BusConfig>& buses, Units& units) {
  RelaysConfig relays;
  units.ReadAddress(table, buses, relays.bus, relays.unit);
  relays.map = LoadRelayMap(MapFile(table));
  for (const char* output : {"fan", "heater"}) {
    const auto channel = table.OptionalInteger(output, {0, 31, "channel"});
    if (!channel) continue;
    if (*channel >= relays.map.channels) {
      table.Fail(output,
                 fmt::format("expected 0 .. {}: the unit ({}) has {} channels",
                             relays.map.channels - 1, relays.map.model, relays.map.channels));
    }
    for (const auto& [other, taken] : relays.channels) {
      if (taken == *channel)
        table.Fail(output, fmt::format("{} is on this channel already", other));
    }
    relays.channels[output] = static_cast<int>(*channel);
  }
  if (!relays.channels.contains("heater") && table.Has("heater_max_degC")) {
    table.Fail("heater_max_degC", "expected none without a heater: which channel switches it?");
  }
  relays.heater_max_degC =
      table.Number("heater_max_degC", {0, 125, "degC"}, relays.heater_max_degC);
  if (relays.channels.empty()) table.FailTable("expected fan, heater or both");
  return relays;
}

// A lean between two axes of which the stand lacks one would turn into a mounting that nobody sees.
void CheckLean(const TomlTable& table, std::string_view key, double lean_deg,
               const std::vector<AxisConfig>& axes, std::array<std::string_view, 2> between) {
  if (lean_deg == 0.0) return;
  for (const std::string_view name : between) {
    if (std::ranges::find(axes, name, &AxisConfig::name) != axes.end()) continue;
    table.Fail(key, fmt::format("expected 0 on a stand without [axis.{}]: it is the lean between "
                                "its {} and its {} axis. How the sensor sits on the table is said "
                                "by mount_x_deg, mount_y_deg and mount_z_deg",
                                name, between[0], between[1]));
  }
}

StandGeometry ReadGeometry(const TomlTable& table, const std::vector<AxisConfig>& axes) {
  StandGeometry geometry;
  for (const auto& [name, value_deg, limit_deg] : AnglesOf(geometry))
    *value_deg = table.Number(name, {-limit_deg, limit_deg, "deg"}, *value_deg);
  CheckLean(table, "outer_middle_deg", geometry.outer_middle_deg, axes, {"outer", "middle"});
  CheckLean(table, "middle_inner_deg", geometry.middle_inner_deg, axes, {"middle", "inner"});
  return geometry;
}

SiteConfig ReadSite(const TomlTable& table) {
  SiteConfig site;
  site.latitude_deg = table.OptionalNumber("latitude_deg", {-90, 90, "deg"});
  site.heading_deg = table.Number("heading_deg", {-360, 360, "deg"}, site.heading_deg);
  return site;
}

ReferenceConfig ReadReference(const TomlTable& table) {
  ReferenceConfig reference;
  reference.scale_uncertainty = table.OptionalNumber("scale_uncertainty", {0, 0.1, ""});
  reference.eccentricity_deg = table.OptionalNumber("eccentricity_deg", {0, 10, "deg"});
  reference.alignment_deg = table.OptionalNumber("alignment_deg", {0, 10, "deg"});
  return reference;
}

void ReadPlaces(const TomlTable& root, StandConfig& stand) {
  // Who is told where a record is may stand in another folder.
  stand.records = std::filesystem::absolute(root.Path("records", stand.records));
  stand.procedure_dirs = root.Paths("procedures", {1, 16});
  stand.control_socket = root.Path("control_socket");
  const std::size_t bytes = stand.control_socket.string().size();
  if (bytes > kMaxSocketPath) {
    root.Fail("control_socket",
              fmt::format("{} has {} bytes; expected at most {}, the limit of Unix "
                          "sockets: choose a shorter path, e.g. in /run",
                          stand.control_socket.string(), bytes, kMaxSocketPath));
  }
  stand.control_socket_mode = root.Permissions("control_socket_mode", stand.control_socket_mode);
  stand.control_socket_owner = root.OptionalString("control_socket_owner");
  stand.control_socket_group = root.OptionalString("control_socket_group");
  stand.control_movers =
      root.OptionalStrings("control_movers", {1, 64}).value_or(std::vector<std::string>());
}

// A line that is asked for more than it can carry would lose samples in every run.
void CheckBusLoad(const TomlTable& root, const StandConfig& stand) {
  for (const BusConfig& bus : stand.buses) {
    double total = 0.0;
    std::vector<std::string> parts;
    for (const DeviceLoad& load : BusLoad(stand, bus)) {
      total += load.share;
      parts.push_back(fmt::format("{} {:.0f} %", load.device, 100 * load.share));
    }
    if (total <= kMostBusLoad) continue;
    root.Table("bus").Table(bus.name).Fail(
        "baud",
        fmt::format("at {} baud the line would be busy {:.0f} % of the time ({}): expected at "
                    "most {:.0f} %, so that a reply that is late or asked for again has its place. "
                    "Raise baud or lower rate_hz",
                    bus.baud, 100 * total, fmt::join(parts, ", "), 100 * kMostBusLoad));
  }
}

template <typename Config>
Config ReadSection(const TomlTable& root, std::string_view key, Config (*read)(const TomlTable&)) {
  const auto table = root.OptionalTable(key);
  return table ? read(*table) : Config();
}

SafetyConfig ReadSafety(const TomlTable& table) {
  SafetyConfig safety;
  safety.silence_s = table.Number("silence_s", {0.05, 60, "s"}, safety.silence_s);
  safety.resume_within_s = table.Number("resume_within_s", {0, 3600, "s"}, safety.resume_within_s);
  safety.min_free_mib = table.Number("min_free_mib", {0, 1e6, "MiB"}, safety.min_free_mib);
  return safety;
}

}  // namespace

StandConfig ReadStandConfig(const TomlTable& root, const fs::path& file) {
  StandConfig stand;
  Units units;
  stand.file = file;
  stand.name = root.String("name");
  ReadPlaces(root, stand);
  stand.buses = ReadBuses(root);
  stand.axes = ReadAxes(root, stand.buses, units);
  stand.gyro = ReadGyro(root.Table("gyro"), stand.buses, units);
  if (const auto table = root.OptionalTable("relays"))
    stand.relays = ReadRelays(*table, stand.buses, units);
  if (const auto table = root.OptionalTable("geometry"))
    stand.geometry = ReadGeometry(*table, stand.axes);
  stand.site = ReadSection(root, "site", ReadSite);
  stand.reference = ReadSection(root, "reference", ReadReference);
  stand.lcm = ReadSection(root, "lcm", ReadLcm);
  stand.safety = ReadSection(root, "safety", ReadSafety);
  if (const auto table = root.OptionalTable("virtual")) stand.virtual_stand = ReadVirtual(*table);
  CheckBusLoad(root, stand);
  return stand;
}

StandConfig LoadStandConfig(const fs::path& file) {
  return TomlTable::FromFile(file).ReadWhole(
      [&](const TomlTable& root) { return ReadStandConfig(root, file); });
}

}  // namespace gyrobench::config
