#include "drivers/drive_setting.h"

#include <fmt/format.h>

#include <array>
#include <string>

#include "base/error.h"
#include "config/words.h"

namespace gyrobench::drivers {

namespace {

std::string NameOf(const ModbusBus& bus, const ModbusUnit& drive) {
  return fmt::format("{} (unit {} on {})", drive.name, drive.unit, bus.description());
}

void RequireStanding(ModbusBus& bus, const ModbusUnit& drive, const config::DriveMap& map,
                     const WrongSetting& setting) {
  std::array<std::uint16_t, 1> status = {};
  bus.ReadHolding(drive, map.status_address, status, "status");
  if (!config::IsBitSet(status[0], map.running_bit)) return;
  throw DeviceError(
      fmt::format("{} turns, by its status 0x{:04X} at 0x{:04X}: its {} are set only while it "
                  "stands. Stop it, and begin again.",
                  NameOf(bus, drive), status[0], map.status_address, setting.name),
      {.device = drive.name, .action = "set " + setting.name});
}

// A drive that takes its parameters up anew with that shows it.
void Save(ModbusBus& bus, const ModbusUnit& drive, const config::DriveMap& map,
          const WrongSetting& setting) {
  bus.WriteRegister(drive, map.control_address, *map.save_value, "save parameters");
  std::array<std::uint16_t, 1> held = {};
  bus.ReadHolding(drive, setting.address, held, setting.name.c_str());
  if (held[0] == setting.expected) return;
  throw DeviceError(
      fmt::format("{}: {} at 0x{:04X}: expected {}, which it had taken, and found {} after they "
                  "were saved. Set it with the vendor's program.",
                  NameOf(bus, drive), setting.name, setting.address, setting.expected, held[0]),
      {.device = drive.name, .action = "save " + setting.name});
}

}  // namespace

Kept Set(ModbusBus& bus, const ModbusUnit& drive, const config::DriveMap& map,
         const WrongSetting& setting) {
  RequireStanding(bus, drive, map, setting);
  bus.WriteVerified(drive, setting.address, setting.expected, setting.name.c_str());
  if (!map.save_value) return Kept::kUntilPowerOff;
  try {
    Save(bus, drive, map, setting);
  } catch (const DeviceError& error) {
    throw DeviceError(
        fmt::format("{} It was set to {} {} and may hold them, but not beyond a power-off: then it "
                    "has {} again. Look what it holds: gyrobench devices.",
                    error.what(), setting.expected, setting.name, setting.found),
        error.failure());
  }
  return Kept::kAlways;
}

}  // namespace gyrobench::drivers
