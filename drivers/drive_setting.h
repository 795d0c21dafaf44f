// Writes into a drive's memory what the stand file says of it.
#pragma once

#include <cstdint>
#include <string>

#include "config/device_maps.h"
#include "drivers/modbus_bus.h"

namespace gyrobench::drivers {

// A parameter of a drive that it holds otherwise than the stand file says.
struct WrongSetting {
  std::string name;  // "pulses per turn"
  std::uint16_t address = 0;
  std::uint16_t found = 0, expected = 0;
};

enum class Kept { kAlways, kUntilPowerOff };

// Sets one parameter, reads it back, and has the drive keep it where its map says how. Nothing
// moves. Throws DeviceError for a drive that turns, that does not answer, or that does not hold
// what it was given; whatever it held before is then there, or the new value.
Kept Set(ModbusBus& bus, const ModbusUnit& drive, const config::DriveMap& map,
         const WrongSetting& setting);

}  // namespace gyrobench::drivers
