// Messages of a gyro that rests, for tests of what happens to them.
#pragma once

#include <cstdint>

#include "base/clock.h"
#include "base/measurement.h"
#include "daemon/telemetry.h"

namespace gyrobench::daemon {

// Three axes at 100 Hz, ten samples a message, without a reference. Time goes on from message to
// message.
class RestingGyro {
 public:
  explicit RestingGyro(Utime start) : utime_(start) {}

  static MeasurementInfo Info();
  // Sends `duration_s` of an output that is `lsb` in the mean, to within one.
  void SendTo(Telemetry& telemetry, double duration_s, int lsb);
  Utime utime() const { return utime_; }  // of the last sample

 private:
  Utime utime_;
  std::int64_t counter_ = 0;
};

}  // namespace gyrobench::daemon
