// A stepper drive with one-frame moves on the shaft of a worm-driven table.
#pragma once

#include <array>
#include <cstdint>
#include <string>

#include "config/stand_config.h"
#include "drivers/axis.h"
#include "drivers/modbus_bus.h"

namespace gyrobench::drivers {

// A move as the drive can express it: whole pulses, whole rpm, whole milliseconds per 1000 rpm.
struct StepperMove {
  std::int32_t pulses = 0;
  std::uint16_t rpm = 0;
  std::uint16_t ramp_ms_per_1000rpm = 0;
  double remainder_pulses = 0.0;  // asked for and not moved, -0.5 .. 0.5
  double rate_deg_s = 0.0;        // of the table, at `rpm`
};

// Turns table degrees into the drive's units:
//   pulses = angle / 360 deg * gear_ratio * pulses_per_turn + remainder of the moves before
//   rpm    = rate / 6 * |gear_ratio|, to the nearest, but never above max_rate_deg_s
//   ramp   = 10^6 / (acceleration / 6 * |gear_ratio|) ms per 1000 rpm, upwards (never more
//   acceleration)
// A negative gear ratio is a shaft that turns against the table. Throws LimitError when the move is
// not finite, is less than a pulse, or is beyond what the drive's registers hold.
StepperMove PlanStepperMove(const config::AxisConfig& config, double remainder_pulses,
                            double angle_deg, double rate_deg_s, double acceleration_deg_s2);

class StepperAxis final : public Axis {
 public:
  StepperAxis(const config::AxisConfig& config, ModbusBus& bus);
  const std::string& name() const override { return config_.name; }
  // Pulses per turn must be those of the map, and no fault be latched; enables the drive and checks
  // that its status says so. `commanded_deg` follows the drive's pulse counter from here on without
  // wrapping.
  AxisState Open() override;
  bool IsMoving() override;
  int PulsesPerTurn() override;
  AxisState Read() override;
  // The drive must be enabled, at rest and without fault: DeviceError otherwise. A frame whose
  // reply was lost is not sent again before the drive has shown that it did not take it.
  double MoveBy(double angle_deg, double rate_deg_s, double acceleration_deg_s2) override;
  void Stop() override;
  void ClearAlarm() override;

 private:
  std::uint16_t ReadWord(std::uint16_t address, const char* what);
  // Into the state; nothing where the map has none.
  void ReadInputs(AxisState* state);
  void Enable();
  void CheckReady(const AxisState& state) const;
  // Away from a limit it may move.
  void CheckLimits(const AxisState& state, double angle_deg) const;
  void Send(const StepperMove& move);
  [[noreturn]] void Fail(const std::string& text, DeviceFailure fields) const;

  const config::AxisConfig config_;
  const config::DriveMap& map_;
  const ModbusUnit unit_;
  ModbusBus& bus_;
  bool position_known_ = false;
  std::uint32_t position_word_ = 0;
  std::int64_t position_pulses_ = 0;  // unwrapped
  double remainder_pulses_ = 0.0;
};

}  // namespace gyrobench::drivers
