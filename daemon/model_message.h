// The three axes as one, as a message.
#pragma once

#include <optional>

#include "calibration/trace/trace.h"
#include "gyrobench/model_result_t.hpp"

namespace gyrobench::daemon {

// All fields but utime, run_id, seq and final. nullopt where a trace has no matrix A: an axis was
// never turned, or not traced. b(T) of all channels is counted from the temperature T0 of the
// first.
std::optional<model_result_t> ModelMessage(const calibration::Traced& traced);

}  // namespace gyrobench::daemon
