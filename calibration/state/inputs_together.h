// Whether several measurements can be those of one sensor that go together, in which order they are
// taken, and where the sensor was switched on anew.
#pragma once

#include <cstddef>
#include <span>
#include <string>
#include <vector>

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

struct OrderedRun {
  std::size_t index = 0;  // of the recordings, as they were given
  bool restart = true;    // the first of its power-on: memories of effects begin anew
};

// By power-on and, within one, by the time since then, whatever the order in which the recordings
// were given. Recordings of one power-on that overlap cannot have been taken one after the other:
// their times do not count from it, each of them restarts, and a remark says so.
std::vector<OrderedRun> OrderRuns(std::span<const Recording* const> recordings,
                                  std::vector<std::string>* remarks);

}  // namespace gyrobench::calibration
