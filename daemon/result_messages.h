// Results as messages.
#pragma once

#include "calibration/results.h"
#include "gyrobench/bias_result_t.hpp"
#include "gyrobench/scale_result_t.hpp"

namespace gyrobench::daemon {

// All fields but utime, run_id, seq and final.
bias_result_t ToMessage(const calibration::BiasResult& result);
scale_result_t ToMessage(const calibration::ScaleResult& result);

}  // namespace gyrobench::daemon
