// One channel from problem to verdict.
#pragma once

#include "calibration/trace/channel_model.h"
#include "calibration/trace/channel_request.h"
#include "calibration/trace/trace_result.h"

namespace gyrobench::calibration {

struct TracedChannel {
  ChannelTrace trace;
  ChannelModel model;
};

TracedChannel TraceChannel(const ChannelRequest& request);

}  // namespace gyrobench::calibration
