#include "drivers/factory.h"

#include <fmt/format.h>

#include <utility>

#include "base/error.h"
#include "drivers/encoder.h"
#include "drivers/gyro_unit.h"
#include "drivers/modbus_bus.h"
#include "drivers/relay_unit.h"
#include "drivers/stepper_axis.h"

namespace gyrobench::drivers {

std::unique_ptr<Axis> MakeAxis(const config::AxisConfig& config, ModbusBus& bus) {
  return std::make_unique<StepperAxis>(config, bus);
}

std::unique_ptr<AngleSensor> MakeAngleSensor(const config::AxisConfig& config, ModbusBus& bus) {
  return std::make_unique<Encoder>(config, bus);
}

std::unique_ptr<Gyro> MakeGyro(const config::GyroConfig& config, ModbusBus& bus) {
  return std::make_unique<GyroUnit>(config, bus);
}

std::unique_ptr<Relays> MakeRelays(const config::RelaysConfig& config, ModbusBus& bus) {
  return std::make_unique<RelayUnit>(config, bus);
}

ModbusDevices::ModbusDevices(Clock& clock) : clock_(clock) {}
ModbusDevices::~ModbusDevices() = default;

void ModbusDevices::AddBus(const config::BusConfig& bus, Clock::Participant& thread,
                           std::function<bool()> hurries) {
  buses_[bus.name] = std::make_unique<ModbusBus>(bus, clock_, thread, std::move(hurries));
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

std::vector<LineFigures> ModbusDevices::Lines() const {
  std::vector<LineFigures> lines;
  for (const auto& [name, bus] : buses_) lines.push_back(bus->Figures());
  return lines;
}

std::int64_t ModbusDevices::Transactions() const {
  std::int64_t sum = 0;
  for (const auto& [name, bus] : buses_) sum += bus->statistics().transactions;
  return sum;
}

}  // namespace gyrobench::drivers
