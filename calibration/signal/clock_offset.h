// Whether the clocks of the gyro's and the reference's loggers were started together.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "calibration/signal/collector.h"

namespace gyrobench::calibration {

// The longest latency that is looked for, either way: clocks may be apart by it.
inline constexpr double kLargestLatency_s = 0.2;

struct ClockOffset {
  double reference_late_s = 0.0;  // the reference's motion comes so long after the gyro's
  double correlation = 0.0;       // of both rates, with that taken off
  double correlation_as_is = 0.0;
  // Of motion that repeats: larger offsets that fit about as well.
  std::vector<double> others_late_s;
};

// The offset, within 5 s either way, at which the gyro's rate and the reference's correlate best,
// of the axis that turned most, on a grid of 0.1 s; the least of those that fit about as well.
// Nothing where there is too little motion, where readings come more than 1 s apart, where the
// rates hardly correlate, or where one of these is within 0.15 s of 0: latencies and filters so
// short are effects, and the trace finds them.
std::optional<ClockOffset> FindClockOffset(const Recording& recording);

// Whether they are farther apart than any latency that is looked for: no result of gyro and
// reference can be then.
bool Contradicts(const ClockOffset& offset);

// What to say of it and to do about it, without the measurement's name. Nothing is shifted here:
// which clock is right is not known.
std::string RemarkOnClocks(const MeasurementInfo& info, const ClockOffset& offset);
// The same of the offset that is found; empty where none is.
std::string RemarkOnClocks(const Recording& recording);

}  // namespace gyrobench::calibration
