// A measurement of any length, event by event: a table that turns and rests by turns.
#pragma once

#include "base/measurement.h"

namespace gyrobench::daemon {

// The gyro's z axis on the inner axis: 20 s at rest, then 90 deg at 30 deg/s, there and back. The
// reference is read at 10 Hz.
class LongMeasurement {
 public:
  explicit LongMeasurement(double gyro_rate_hz) : gyro_rate_hz_(gyro_rate_hz) {}

  static MeasurementInfo Info();
  // Goes on until `end_s` since the begin.
  void FeedUntil(double end_s, MeasurementSink& sink);

 private:
  double TimeS() const { return static_cast<double>(samples_) / gyro_rate_hz_; }

  double gyro_rate_hz_;
  std::int64_t samples_ = 0, readings_ = 0;
};

}  // namespace gyrobench::daemon
