// The narrow interface of the reference angle sensor of one axis.
#pragma once

#include <array>
#include <cstdint>
#include <string>

#include "base/clock.h"

namespace gyrobench::drivers {

struct AngleReading {
  Utime utime = 0;          // host clock, when the sensor took the request
  Utime utime_request = 0;  // request written
  Utime utime_reply = 0;    // reply complete
  std::int64_t counts = 0;  // as read, unwrapped over the sensor's range
  double angle_deg = 0.0;   // table angle, right-handed about the axis; sign and offset of the
                            // configuration applied
};

// Registers as they came, that of the lower address first.
struct RawAngle {
  Utime utime = 0;  // host clock, when the sensor took the request
  std::array<std::uint16_t, 2> words = {};
};

// Absolute angle sensor on the table side. Calls throw DeviceError and belong to the thread of the
// bus.
class AngleSensor {
 public:
  virtual ~AngleSensor() = default;
  virtual const std::string& name() const = 0;
  // Returns its first reading.
  virtual AngleReading Open() = 0;
  virtual AngleReading Read() = 0;
  // Whatever the configuration would make of it: nothing is doubted, and nothing of it is known to
  // Read afterwards.
  virtual RawAngle ReadRaw() = 0;
};

}  // namespace gyrobench::drivers
