#include "drivers/drive_setting.h"

#include <fmt/format.h>

#include <array>

#include "base/error.h"
#include "config/words.h"

namespace gyrobench::drivers {

Kept Set(ModbusBus& bus, const ModbusUnit& drive, const config::DriveMap& map,
         const WrongSetting& setting) {
  std::array<std::uint16_t, 1> status = {};
  bus.ReadHolding(drive, map.status_address, status, "status");
  if (config::IsBitSet(status[0], map.running_bit)) {
    throw DeviceError(
        fmt::format("{} (unit {} on {}) turns, by its status 0x{:04X} at 0x{:04X}: its {} are set "
                    "only while it stands. Stop it, and begin again.",
                    drive.name, drive.unit, bus.description(), status[0], map.status_address,
                    setting.name),
        {.device = drive.name, .action = "set " + setting.name});
  }
  bus.WriteVerified(drive, setting.address, setting.expected, setting.name.c_str());
  if (!map.save_value) return Kept::kUntilPowerOff;
  bus.WriteRegister(drive, map.control_address, *map.save_value, "save parameters");
  // A drive that takes the parameters up anew shows it here.
  std::array<std::uint16_t, 1> held = {};
  bus.ReadHolding(drive, setting.address, held, setting.name.c_str());
  if (held[0] != setting.expected) {
    throw DeviceError(
        fmt::format("{} (unit {} on {}): {} at 0x{:04X}: expected {}, which it had taken, and "
                    "found {} after they were saved. Set it with the vendor's program.",
                    drive.name, drive.unit, bus.description(), setting.name, setting.address,
                    setting.expected, held[0]),
        {.device = drive.name, .action = "save " + setting.name});
  }
  return Kept::kAlways;
}

}  // namespace gyrobench::drivers
