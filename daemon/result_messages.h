// Results as messages.
#pragma once

#include <vector>

#include "calibration/estimators/results.h"
#include "calibration/trace/trace_result.h"
#include "gyrobench/bias_result_t.hpp"
#include "gyrobench/scale_result_t.hpp"
#include "gyrobench/trace_result_t.hpp"

namespace gyrobench::daemon {

// All fields but utime, run_id, seq and final.
bias_result_t ToMessage(const calibration::BiasResult& result);
scale_result_t ToMessage(const calibration::ScaleResult& result);
// The verdict's message, then one for each effect.
std::vector<trace_result_t> ToMessages(const calibration::ChannelTrace& channel);

}  // namespace gyrobench::daemon
