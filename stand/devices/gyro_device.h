// The gyro unit, register by register as in docs/gyro-unit.md.
#pragma once

#include "config/device_maps.h"
#include "stand/bench_physics.h"
#include "stand/devices/device.h"

namespace gyrobench::stand {

class GyroDevice final : public Device {
 public:
  GyroDevice(const config::GyroUnitMap& map, Physics& physics);
  ModbusException Read(int function, std::uint16_t address, std::span<std::uint16_t> words,
                       Utime at) override;
  ModbusException Write(std::uint16_t address, std::span<const std::uint16_t> words,
                        Utime at) override;
  ModbusException Disguise(std::uint16_t address, std::span<std::uint16_t> words) override;
  void FrameRejected() override { ++frames_rejected_; }

 private:
  ModbusException ReadInput(std::uint16_t address, std::span<std::uint16_t> words,
                            const GyroSampler& gyro, double t_s) const;
  void ReadBlock(std::uint16_t address, std::span<std::uint16_t> words, const GyroSampler& gyro,
                 double t_s) const;
  std::uint32_t FirstOfBlock(std::uint16_t wanted_mod_span, const GyroSampler& gyro) const;

  config::GyroUnitMap map_;
  Physics& physics_;
  std::uint32_t serial_number_;
  int boot_count_;  // that frames_rejected_ counts from
  std::uint32_t frames_rejected_ = 0;
};

}  // namespace gyrobench::stand
