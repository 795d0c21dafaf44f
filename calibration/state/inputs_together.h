// Whether several measurements can be those of one sensor that go together.
#pragma once

#include <span>

#include "base/measurement.h"
#include "calibration/signal/collector.h"

namespace gyrobench::calibration {

// What is asked of one of them.
struct InputSpan {
  const MeasurementInfo* info = nullptr;
  double first_time_s = 0.0, last_time_s = 0.0;
};

// Measurements that name the same power-on lie one after the other, in whatever order they are
// given: times that overlap cannot all count from it. Throws DataError with file and line of the
// key and of the first row of the later one, what was expected and found, and what to do.
void CheckPowerOns(std::span<const InputSpan> inputs);

// All of the above, and besides: one unit, one range, one count of zero, no measurement twice.
// Throws DataError likewise.
void CheckTogether(std::span<const Recording* const> recordings);

}  // namespace gyrobench::calibration
