// Stepper drive with one-frame moves (config::DriveMap).
#pragma once

#include <array>
#include <optional>

#include "config/device_maps.h"
#include "stand/bench_physics.h"
#include "stand/devices/device.h"

namespace gyrobench::stand {

// Path 0 is the only path. Writing start_value to its last word, or 0x10 to the trigger register,
// runs it: relative (the map's mode) or absolute (mode 1) to the command count. A disabled drive,
// or one with an alarm, takes the words and does not move. Velocity mode is refused: the bench
// never uses it. The pulses per turn can be set while it stands, and saved.
class DriveDevice final : public Device {
 public:
  DriveDevice(std::string name, const config::DriveMap& map, std::size_t axis, Physics& physics);
  ModbusException Read(int function, std::uint16_t address, std::span<std::uint16_t> words,
                       Utime at) override;
  ModbusException Write(std::uint16_t address, std::span<const std::uint16_t> words,
                        Utime at) override;
  ModbusException Disguise(std::uint16_t address, std::span<std::uint16_t> words) override;
  void LosePower(Utime at) override;

 private:
  static constexpr std::size_t kPathWords = 8;
  std::optional<std::uint16_t> Register(std::uint16_t address,
                                        const Physics::DriveView& view) const;
  std::uint16_t Status(const Physics::DriveView& view) const;
  // Where the map has them.
  std::uint16_t Inputs(const Physics::DriveView& view) const;
  bool IsWritable(std::uint16_t address) const;
  ModbusException WriteOne(std::uint16_t address, std::uint16_t value, Utime at);
  ModbusException Trigger(std::uint16_t value, Utime at);
  ModbusException RunPath(Utime at);
  std::size_t PathIndex(std::uint16_t address) const;
  // Motor pulses of one that is commanded.
  double PulsesOfOne() const { return 1.0 * map_.pulses_per_turn / pulses_per_turn_; }

  config::DriveMap map_;
  std::size_t axis_;
  Physics& physics_;
  bool enabled_ = false;
  // A parameter: as it is set, and as it is after the power was lost.
  int pulses_per_turn_, saved_pulses_per_turn_;
  std::array<std::uint16_t, kPathWords> path_ = {};
};

}  // namespace gyrobench::stand
