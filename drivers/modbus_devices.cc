#include "drivers/modbus_devices.h"

#include <fmt/format.h>

#include "base/error.h"
#include "drivers/factory.h"
#include "drivers/modbus_bus.h"

namespace gyrobench::drivers {

ModbusDevices::ModbusDevices(Clock& clock) : clock_(clock) {}
ModbusDevices::~ModbusDevices() = default;

void ModbusDevices::AddBus(const config::BusConfig& bus, Clock::Participant& thread) {
  buses_[bus.name] = std::make_unique<ModbusBus>(bus, clock_, thread);
}

ModbusBus& ModbusDevices::BusOf(const std::string& name) {
  const auto found = buses_.find(name);
  if (found == buses_.end()) throw ConfigError(fmt::format("no bus '{}' in the stand file", name));
  return *found->second;
}

std::unique_ptr<Axis> ModbusDevices::MakeAxis(const config::AxisConfig& config) {
  return drivers::MakeAxis(config, BusOf(config.drive.bus));
}

std::unique_ptr<AngleSensor> ModbusDevices::MakeAngleSensor(const config::AxisConfig& config) {
  return drivers::MakeAngleSensor(config, BusOf(config.encoder.bus));
}

std::unique_ptr<Gyro> ModbusDevices::MakeGyro(const config::GyroConfig& config) {
  return drivers::MakeGyro(config, BusOf(config.bus));
}

std::unique_ptr<Relays> ModbusDevices::MakeRelays(const config::RelaysConfig& config) {
  return drivers::MakeRelays(config, BusOf(config.bus));
}

std::int64_t ModbusDevices::Transactions() const {
  std::int64_t sum = 0;
  for (const auto& [name, bus] : buses_) sum += bus->statistics().transactions;
  return sum;
}

}  // namespace gyrobench::drivers
