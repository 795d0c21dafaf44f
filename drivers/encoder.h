// An absolute encoder on the table side, over Modbus.
#pragma once

#include <array>
#include <cstdint>
#include <string>

#include "config/stand_config.h"
#include "drivers/angle_sensor.h"
#include "drivers/modbus_bus.h"

namespace gyrobench::drivers {

// angle = sign * counts * 360 deg / counts_per_turn + offset, counts unwrapped over range_counts.
//
// The range of the sensor repeats; the first reading after Open is taken in the repetition that
// puts the angle nearest to zero, and each later one nearest to the one before (so the table must
// move less than half the range between two readings).
class Encoder final : public AngleSensor {
 public:
  // Throws ConfigError for a map whose words cannot hold its range.
  Encoder(const config::AxisConfig& config, ModbusBus& bus);
  const std::string& name() const override { return name_; }
  void Open() override;
  // DeviceError also for a value outside the sensor's range.
  AngleReading Read() override;

 private:
  double AngleDeg(std::int64_t counts) const;
  std::int64_t NearestToZero(std::uint32_t raw) const;

  const std::string name_;
  const config::EncoderConfig config_;
  const ModbusUnit unit_;
  ModbusBus& bus_;
  bool known_ = false;
  std::uint32_t raw_ = 0;
  std::int64_t counts_ = 0;
};

}  // namespace gyrobench::drivers
