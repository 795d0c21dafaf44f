// The drivers by configuration, and the devices of a stand on its lines, real or virtual. The one
// place to extend when a new kind of device comes.
#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "config/stand_config.h"
#include "drivers/angle_sensor.h"
#include "drivers/axis.h"
#include "drivers/device_maker.h"
#include "drivers/gyro.h"
#include "drivers/relays.h"

namespace gyrobench::drivers {

class ModbusBus;

// `bus` is the line that the configuration names, and outlives the device. Nothing is sent before
// Open. Each throws ConfigError for a register map that cannot work.
std::unique_ptr<Axis> MakeAxis(const config::AxisConfig& config, ModbusBus& bus);
std::unique_ptr<AngleSensor> MakeAngleSensor(const config::AxisConfig& config, ModbusBus& bus);
std::unique_ptr<Gyro> MakeGyro(const config::GyroConfig& config, ModbusBus& bus);
std::unique_ptr<Relays> MakeRelays(const config::RelaysConfig& config, ModbusBus& bus);

// Owns the lines; outlives the devices that it made.
class ModbusDevices final : public DeviceMaker {
 public:
  explicit ModbusDevices(Clock& clock);
  ~ModbusDevices() override;
  void AddBus(const config::BusConfig& bus, Clock::Participant& thread,
              std::function<bool()> hurries) override;
  std::unique_ptr<Axis> MakeAxis(const config::AxisConfig& config) override;
  std::unique_ptr<AngleSensor> MakeAngleSensor(const config::AxisConfig& config) override;
  std::unique_ptr<Gyro> MakeGyro(const config::GyroConfig& config) override;
  std::unique_ptr<Relays> MakeRelays(const config::RelaysConfig& config) override;
  std::vector<LineFigures> Lines() const override;

  // Modbus transactions so far, all buses. Only while no thread uses them.
  std::int64_t Transactions() const;

 private:
  ModbusBus& BusOf(const std::string& name);

  Clock& clock_;
  std::map<std::string, std::unique_ptr<ModbusBus>> buses_;  // by name
};

}  // namespace gyrobench::drivers
