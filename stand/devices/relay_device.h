// Relay unit (config::RelayMap): coils that switch the fan and the heater of the gyro unit.
#pragma once

#include <map>
#include <vector>

#include "config/stand_config.h"
#include "stand/bench_physics.h"
#include "stand/devices/device.h"

namespace gyrobench::stand {

class RelayDevice final : public Device {
 public:
  RelayDevice(const config::RelaysConfig& config, Physics& physics);
  // It has coils only.
  ModbusException Read(int function, std::uint16_t address, std::span<std::uint16_t> words,
                       Utime at) override;
  ModbusException Write(std::uint16_t address, std::span<const std::uint16_t> words,
                        Utime at) override;
  ModbusException ReadCoils(std::uint16_t address, std::span<bool> coils) override;
  ModbusException WriteCoil(std::uint16_t address, bool on, Utime at) override;
  ModbusException Disguise(std::uint16_t address, std::span<std::uint16_t> words) override;
  void LosePower(Utime at) override;

 private:
  const std::uint16_t first_coil_;
  const std::map<std::string, int> channels_;
  Physics& physics_;
  std::vector<bool> on_;  // by channel
};

}  // namespace gyrobench::stand
