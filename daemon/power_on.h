// To which power-on of the sensor a measurement belongs.
#pragma once

#include <cstdint>
#include <optional>
#include <string>

#include "base/clock.h"
#include "drivers/gyro.h"

namespace gyrobench::daemon {

struct PowerOn {
  // Moment, serial number and boot counter: no two power-ons have one name.
  std::string name;
  Utime utime = 0;  // host time of it, from which measurements count
};

// Keeps one moment for each start of the unit, by the host's clock, from which all measurements
// until the next start count: so they follow each other whatever the unit's own clock does.
// Another daemon on the same sensor estimates a moment of its own, and with it gives another name.
class PowerOnWatch {
 public:
  // Of each block that the unit with this serial number gave.
  void Take(std::uint32_t serial_number, const drivers::GyroBlock& block);
  // Empty before the first block, and while the time since the unit's start is not known.
  const std::optional<PowerOn>& power_on() const { return power_on_; }

 private:
  bool IsSame(std::uint32_t serial_number, const drivers::GyroBlock& block) const;

  std::uint32_t serial_number_ = 0;
  std::optional<int> boot_count_;
  std::optional<PowerOn> power_on_;
};

}  // namespace gyrobench::daemon
