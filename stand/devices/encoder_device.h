// Absolute encoder (config::EncoderMap).
#pragma once

#include "config/device_maps.h"
#include "stand/bench_physics.h"
#include "stand/devices/device.h"

namespace gyrobench::stand {

class EncoderDevice final : public Device {
 public:
  EncoderDevice(std::string name, const config::EncoderMap& map, std::size_t axis,
                Physics& physics);
  ModbusException Read(int function, std::uint16_t address, std::span<std::uint16_t> words,
                       Utime at) override;
  ModbusException Write(std::uint16_t address, std::span<const std::uint16_t> words,
                        Utime at) override;
  ModbusException Disguise(std::uint16_t address, std::span<std::uint16_t> words) override;

 private:
  config::EncoderMap map_;
  std::size_t axis_;
  Physics& physics_;
};

}  // namespace gyrobench::stand
