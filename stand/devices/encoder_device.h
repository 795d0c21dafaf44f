// Absolute encoder (config::EncoderMap).
#pragma once

#include <vector>

#include "config/device_maps.h"
#include "stand/bench_physics.h"
#include "stand/devices/device.h"

namespace gyrobench::stand {

class EncoderDevice final : public Device {
 public:
  struct Interval {
    Utime begin = 0, end = 0;
  };
  // While `frozen` it repeats the last value that it gave.
  EncoderDevice(std::string name, const config::EncoderMap& map, std::size_t axis, Physics& physics,
                std::vector<Interval> frozen);
  ModbusException Read(int function, std::uint16_t address, std::span<std::uint16_t> words,
                       Utime at) override;
  ModbusException Write(std::uint16_t address, std::span<const std::uint16_t> words,
                        Utime at) override;
  ModbusException Disguise(std::uint16_t address, std::span<std::uint16_t> words) override;

 private:
  bool Frozen(Utime at) const;

  config::EncoderMap map_;
  std::size_t axis_;
  Physics& physics_;
  std::vector<Interval> frozen_;
  bool known_ = false;
  std::uint32_t counts_ = 0;
};

}  // namespace gyrobench::stand
