#include "drivers/line_scan.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <optional>

#include "drivers/modbus_bus.h"

namespace gyrobench::drivers {
namespace {

using Transport = config::BusConfig::Transport;

// Long enough for a device at the bench; one that is expected and silent is asked again with all
// the time that the stand file gives it.
constexpr double kHailTimeout_s = 0.05;
// Rates that drives, encoders and microcontrollers are sold with or set to.
constexpr std::array<int, 9> kUsualBauds = {9600,   19200,  38400,  57600,  115200,
                                            230400, 460800, 500000, 1000000};
// Of one unit number alone nothing can be said about the line.
constexpr int kLeastUnreadable = 3;

struct ExpectedUnit {
  int unit;
  std::string device;
  UnitKind kind;
};

std::vector<ExpectedUnit> ExpectedOn(const config::StandConfig& stand, const std::string& bus) {
  std::vector<ExpectedUnit> expected;
  const auto add = [&](const std::string& on, int unit, std::string device, UnitKind kind) {
    if (on == bus) expected.push_back({unit, std::move(device), kind});
  };
  for (const config::AxisConfig& axis : stand.axes) {
    add(axis.drive.bus, axis.drive.unit, "axis." + axis.name + " drive", UnitKind::kDrive);
    add(axis.encoder.bus, axis.encoder.unit, "axis." + axis.name + " encoder", UnitKind::kEncoder);
  }
  add(stand.gyro.bus, stand.gyro.unit, "gyro", UnitKind::kGyroUnit);
  if (stand.relays) add(stand.relays->bus, stand.relays->unit, "relays", UnitKind::kRelayUnit);
  return expected;
}

LineSetting SettingOf(const config::BusConfig& bus) {
  return {bus.baud, bus.parity, bus.stop_bits};
}

std::vector<LineSetting> UsualSettings(const config::BusConfig& bus) {
  std::vector<LineSetting> settings = {SettingOf(bus)};
  if (bus.transport == Transport::kTcp) return settings;
  for (const int baud : kUsualBauds) {
    for (const LineSetting& setting : {LineSetting{baud, 'N', 1}, LineSetting{baud, 'E', 1},
                                       LineSetting{baud, 'O', 1}, LineSetting{baud, 'N', 2}}) {
      if (!(setting == settings.front())) settings.push_back(setting);
    }
  }
  return settings;
}

class LineScan {
 public:
  LineScan(const config::StandConfig& stand, const config::BusConfig& bus,
           const ScanOptions& options, Clock& clock, Clock::Participant& participant,
           const ScanProgress& progress)
      : maps_(MapsOf(stand)),
        expected_(ExpectedOn(stand, bus.name)),
        options_(options),
        clock_(clock),
        participant_(participant),
        progress_(progress) {
    report_.bus = bus;
  }

  LineReport Run() {
    std::vector<LineSetting> settings = options_.settings;
    if (settings.empty()) settings.push_back(SettingOf(report_.bus));
    to_ask_ = options_.units.size() * settings.size();
    for (const LineSetting& setting : settings) AskAll(options_.units, setting, kHailTimeout_s);
    report_.asked = static_cast<int>(options_.units.size());
    report_.all_unreadable = report_.asked >= kLeastUnreadable &&
                             static_cast<int>(report_.found.size()) ==
                                 report_.asked * static_cast<int>(settings.size()) &&
                             std::ranges::all_of(report_.found, [](const FoundUnit& found) {
                               return found.identity.kind == UnitKind::kUnreadable;
                             });
    if (options_.settings.empty() && !report_.all_unreadable) SeekSilent();
    for (const ExpectedUnit& expected : expected_) {
      if (!Answered(expected.unit)) report_.missing.push_back({expected.unit, expected.device});
    }
    std::ranges::stable_sort(report_.found, {}, &FoundUnit::unit);
    return std::move(report_);
  }

 private:
  bool Answered(int unit) const {
    return std::ranges::any_of(report_.found,
                               [unit](const FoundUnit& found) { return found.unit == unit; });
  }

  // Replies that cannot be read are what another setting looks like: they do not end the search.
  void SeekSilent() {
    std::vector<int> silent;
    for (const ExpectedUnit& expected : expected_) {
      if (!Answered(expected.unit)) silent.push_back(expected.unit);
    }
    const std::vector<LineSetting> settings = UsualSettings(report_.bus);
    asked_ = 0;
    to_ask_ = silent.size() * settings.size();
    const LineSetting own = SettingOf(report_.bus);
    for (const LineSetting& setting : settings) {
      if (silent.empty()) return;
      AskAll(silent, setting, setting == own ? report_.bus.response_timeout_s : kHailTimeout_s);
      std::erase_if(silent, [this](int unit) { return Answered(unit); });
    }
  }

  void AskAll(const std::vector<int>& units, const LineSetting& setting, double timeout_s) {
    config::BusConfig config = report_.bus;
    config.baud = setting.baud;
    config.parity = setting.parity;
    config.stop_bits = setting.stop_bits;
    config.response_timeout_s = std::min(timeout_s, config.response_timeout_s);
    config.retries = 0;
    const bool seeks = !(setting == SettingOf(report_.bus)) && options_.settings.empty();
    ModbusBus bus(config, clock_, participant_);
    for (const int unit : units) {
      progress_(
          static_cast<double>(asked_++) / static_cast<double>(std::max<std::size_t>(to_ask_, 1)),
          fmt::format("bus {}, {}, unit {}", config.name, Describe(setting), unit));
      const UnitIdentity identity = Identify(bus, unit, maps_);
      if (identity.kind == UnitKind::kSilent) continue;
      if (seeks && identity.kind == UnitKind::kUnreadable) continue;
      Add({.unit = unit, .setting = setting, .identity = identity});
    }
  }

  void Add(FoundUnit found) {
    const auto expected = std::ranges::find(expected_, found.unit, &ExpectedUnit::unit);
    if (expected != expected_.end()) {
      found.expected = expected->device;
      found.as_expected =
          found.identity.kind == expected->kind &&
          (report_.bus.transport == Transport::kTcp || found.setting == SettingOf(report_.bus));
    }
    report_.found.push_back(std::move(found));
  }

  const KnownMaps maps_;
  const std::vector<ExpectedUnit> expected_;
  const ScanOptions& options_;
  Clock& clock_;
  Clock::Participant& participant_;
  const ScanProgress& progress_;
  LineReport report_;
  std::size_t asked_ = 0, to_ask_ = 0;
};

}  // namespace

std::string Describe(const LineSetting& setting) {
  return fmt::format("{} baud 8{}{}", setting.baud, setting.parity, setting.stop_bits);
}

bool LineReport::IsAsExpected() const {
  return missing.empty() && !all_unreadable && std::ranges::all_of(found, [](const FoundUnit& one) {
           return one.expected.empty() || one.as_expected;
         });
}

LineReport ScanLine(const config::StandConfig& stand, const config::BusConfig& bus,
                    const ScanOptions& options, Clock& clock, Clock::Participant& participant,
                    const ScanProgress& progress) {
  return LineScan(stand, bus, options, clock, participant, progress).Run();
}

}  // namespace gyrobench::drivers
