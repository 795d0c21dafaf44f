// An absolute encoder on the table side, over Modbus.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
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
//
// A value that the table cannot have reached since the last one at twice the axis's largest rate is
// doubted: it is read again at once, and thrown away as DeviceError where it stays so. Values that
// agree with each other for longer than a burst of errors lasts are believed again: in the
// repetition nearest to zero where the range holds all angles that the axis may have, and in that
// nearest to the last believed value where it does not. So no run of wrong values shifts the axis
// by a range.
class Encoder final : public AngleSensor {
 public:
  // Throws ConfigError for a map whose words cannot hold its range.
  Encoder(const config::AxisConfig& config, ModbusBus& bus);
  const std::string& name() const override { return name_; }
  AngleReading Open() override;
  // DeviceError also for a value outside the sensor's range, and for one that is doubted.
  AngleReading Read() override;
  RawAngle ReadRaw() override;

 private:
  Timing ReadWords(std::array<std::uint16_t, 2>& words);
  // A value as the sensor gave it.
  struct Value {
    std::uint32_t raw = 0;
    Timing timing;
  };
  Value ReadValue();
  double AngleDeg(std::int64_t counts) const;
  std::int64_t NearestToZero(std::uint32_t raw) const;
  // From `before` to `now`, the shorter way round [counts].
  std::int64_t Step(const Value& before, const Value& now) const;
  // Whether the table can have moved so in the time between them.
  bool CanFollow(const Value& before, const Value& now) const;
  // Whether doubted values have agreed for long enough to be believed.
  bool BelieveAfterAll(const Value& value);
  AngleReading Accept(const Value& value, std::int64_t counts);
  [[noreturn]] void Doubt(const Value& value) const;

  const std::string name_;
  const config::EncoderConfig config_;
  const double max_rate_deg_s_;
  const double span_deg_;  // between the soft limits
  const ModbusUnit unit_;
  ModbusBus& bus_;
  bool known_ = false;
  Value last_;  // believed
  std::int64_t counts_ = 0;
  std::optional<Value> doubted_;  // the last one, where one was doubted since
  Utime doubted_since_ = 0;       // from when on they agree
};

}  // namespace gyrobench::drivers
