// The drivers by configuration. The one place to extend when a new kind of device comes.
#pragma once

#include <memory>

#include "config/stand_config.h"
#include "drivers/angle_sensor.h"
#include "drivers/axis.h"
#include "drivers/gyro.h"
#include "drivers/modbus_bus.h"
#include "drivers/relays.h"

namespace gyrobench::drivers {

// `bus` is the line that the configuration names, and outlives the device. Nothing is sent before
// Open. Each throws ConfigError for a register map that cannot work.
std::unique_ptr<Axis> MakeAxis(const config::AxisConfig& config, ModbusBus& bus);
std::unique_ptr<AngleSensor> MakeAngleSensor(const config::AxisConfig& config, ModbusBus& bus);
std::unique_ptr<Gyro> MakeGyro(const config::GyroConfig& config, ModbusBus& bus);
std::unique_ptr<Relays> MakeRelays(const config::RelaysConfig& config, ModbusBus& bus);

}  // namespace gyrobench::drivers
