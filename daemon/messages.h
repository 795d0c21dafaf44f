// Blocks of the gyro unit and results of the analysis as messages.
#pragma once

#include <optional>
#include <vector>

#include "calibration/estimators/results.h"
#include "calibration/trace/trace.h"
#include "calibration/trace/trace_result.h"
#include "drivers/gyro.h"
#include "gyrobench/bias_result_t.hpp"
#include "gyrobench/gyro_t.hpp"
#include "gyrobench/model_result_t.hpp"
#include "gyrobench/scale_result_t.hpp"
#include "gyrobench/trace_result_t.hpp"

namespace gyrobench::daemon {

// All fields but utime, run_id, seq and final.
bias_result_t ToMessage(const calibration::BiasResult& result);
scale_result_t ToMessage(const calibration::ScaleResult& result);
// The verdict's message, then one for each effect.
std::vector<trace_result_t> ToMessages(const calibration::ChannelTrace& channel);

// All fields of `message` but run_id and seq; its memory is used again.
void FillMessage(const drivers::GyroBlock& block, const drivers::GyroIdentity& identity,
                 gyro_t& message);

// All fields but utime, run_id, seq and final. nullopt where a trace has no matrix A: an axis was
// never turned, or not traced. b(T) of all channels is counted from the temperature T0 of the
// first.
std::optional<model_result_t> ModelMessage(const calibration::Traced& traced);

}  // namespace gyrobench::daemon
