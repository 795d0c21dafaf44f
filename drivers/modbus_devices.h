// The devices of a real stand, and of the virtual one.
#pragma once

#include <cstdint>
#include <map>
#include <memory>
#include <string>

#include "drivers/device_maker.h"

namespace gyrobench::drivers {

class ModbusBus;

// Owns the lines; outlives the devices that it made.
class ModbusDevices final : public DeviceMaker {
 public:
  explicit ModbusDevices(Clock& clock);
  ~ModbusDevices() override;
  void AddBus(const config::BusConfig& bus, Clock::Participant& thread) override;
  std::unique_ptr<Axis> MakeAxis(const config::AxisConfig& config) override;
  std::unique_ptr<AngleSensor> MakeAngleSensor(const config::AxisConfig& config) override;
  std::unique_ptr<Gyro> MakeGyro(const config::GyroConfig& config) override;
  std::unique_ptr<Relays> MakeRelays(const config::RelaysConfig& config) override;

  // Modbus transactions so far, all buses. Only while no thread uses them.
  std::int64_t Transactions() const;

 private:
  ModbusBus& BusOf(const std::string& name);

  Clock& clock_;
  std::map<std::string, std::unique_ptr<ModbusBus>> buses_;  // by name
};

}  // namespace gyrobench::drivers
