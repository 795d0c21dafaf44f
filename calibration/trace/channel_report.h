// One channel from problem to verdict.
#pragma once

#include "calibration/trace/channel_model.h"
#include "calibration/trace/channel_request.h"
#include "calibration/trace/trace_result.h"
#include "calibration/vector/channel_row.h"

namespace gyrobench::calibration {

struct TracedChannel {
  ChannelTrace trace;
  ChannelModel model;
  ChannelRow row;  // for the three axes together
};

TracedChannel TraceChannel(const ChannelRequest& request);

}  // namespace gyrobench::calibration
