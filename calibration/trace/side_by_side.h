// Work that is shared out over as many threads as the machine has cores.
#pragma once

#include <cstddef>
#include <functional>
#include <span>
#include <vector>

#include "calibration/trace/channel_report.h"

namespace gyrobench::calibration {

// Calls `one` with each number from 0 to `count` - 1. What one throws is thrown when all have
// ended, of several the one of the lowest number.
void OnAllCores(std::size_t count, const std::function<void(std::size_t)>& one);

// Traces channels. What is shared out are the searches of all of them, on all data and on parts of
// them, because three channels alone leave one of two cores idle for a third of the time. A search
// reads what its channel has prepared and writes what is its own, so that the results are the same
// to the last digit however many threads there are. `one_done` is called for each channel, in
// order, by the thread that calls. What a search throws is thrown when all have ended.
std::vector<TracedChannel> TraceSideBySide(std::span<const ChannelRequest* const> requests,
                                           const std::function<void()>& one_done);

}  // namespace gyrobench::calibration
