// The emulated unit in the virtual stand's place of its own gyro unit.
#pragma once

#include <filesystem>
#include <mutex>

#include "config/device_maps.h"
#include "stand/bench_physics.h"
#include "stand/devices/device.h"
#include "tests/firmware/emulation/emulated_unit.h"
#include "tests/firmware/emulation/unit_master.h"

namespace gyrobench::firmware {

// Every request goes through the emulated serial line, and the sensor on the emulated bus shows
// what the stand's physics make of its sensor. Of the scenario's unit, `tick_rel` is the
// resonator's error; its other keys are of the stand's own unit and do nothing here. The scenario's
// turnaround must be longer than the firmware takes, some 3 ms (bus.turnaround_s).
class EmulatedGyroDevice final : public stand::Device {
 public:
  // `start`: the power-on of the physics.
  EmulatedGyroDevice(const std::filesystem::path& image, const config::GyroUnitMap& map,
                     stand::Physics& physics, Utime start);

  stand::ModbusException Read(int function, std::uint16_t address, std::span<std::uint16_t> words,
                              Utime at) override;
  stand::ModbusException Write(std::uint16_t address, std::span<const std::uint16_t> words,
                               Utime at) override;
  stand::ModbusException Disguise(std::uint16_t address, std::span<std::uint16_t> words) override;

  // Lets the processor run up to shortly before `now`, so that the next request finds it there: in
  // real time what passed since the last one would make its reply late. From any thread.
  void CatchUp(Utime now);

 private:
  VirtualMpu6050::Words Sample(double t_s, const VirtualMpu6050::Settings& settings);
  Utime At(double t_s) const { return start_ + FromSeconds(t_s); }

  const config::GyroUnitMap map_;
  stand::Physics& physics_;
  std::mutex mutex_;  // guards what follows `start_`
  const Utime start_;
  VirtualMpu6050 sensor_;
  EmulatedUnit unit_;
  UnitMaster master_;
  // What the physics were told that the sensor is set to, and their sample that comes next.
  VirtualMpu6050::Settings settings_;
  bool set_ = false;
  std::uint32_t next_ = 0;
};

}  // namespace gyrobench::firmware
