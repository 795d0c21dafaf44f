// In which order the measurements of a trace are taken, and where the sensor was switched on anew.
#pragma once

#include <cstddef>
#include <span>
#include <string>
#include <vector>

#include "calibration/signal/collector.h"

namespace gyrobench::calibration {

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
