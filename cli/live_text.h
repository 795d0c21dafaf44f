// Live messages as text, one line each, and as JSON.
#pragma once

#include <cstdint>
#include <nlohmann/json.hpp>
#include <string>

#include "cli/live_feed.h"
#include "presentation/text_layout.h"

namespace gyrobench::cli {

// "x", "y", "z"; "?" for what is no axis.
std::string SensorAxisName(int axis);

// "idle", "running" ... as the control socket says them.
std::string StateName(int state);

// "scale z: 0.0076336 ± 0.0000021 deg/s per LSB"; "bias z: -12.30 ± 0.15 LSB at 25.0 degC".
std::string EstimateText(const scale_result_t& result);
std::string EstimateText(const bias_result_t& result);

// "turn inner +9 deg", of a message that begins or ends a segment.
std::string SegmentText(const run_t& message);

// "14:03:12.345  RUN  ...", without a newline.
std::string LiveLine(const LiveMessage& message, const presentation::Terminal& terminal);

// What the message says, but for what a status measures. Two of one NewsKey with the same text
// say the same.
std::string NewsText(const LiveMessage& message);
// What a message speaks of, of all that its channel does: an axis, a device.
std::string NewsKey(const LiveMessage& message);

// Every field under its own name, with "channel", "lost", "sender" and "stranger". Values that are
// not finite become null.
nlohmann::json LiveJson(const LiveMessage& message);

}  // namespace gyrobench::cli
