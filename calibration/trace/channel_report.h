// One channel from problem to verdict.
#pragma once

#include <vector>

#include "calibration/effects/channel_model.h"
#include "calibration/sensor/make_vector.h"
#include "calibration/trace/bench_finding.h"
#include "calibration/trace/channel_request.h"
#include "calibration/trace/trace_result.h"

namespace gyrobench::calibration {

struct TracedChannel {
  ChannelTrace trace;
  ChannelModel model;
  ChannelRow row;  // for the three axes together
  BenchFindings bench_findings;
};

TracedChannel TraceChannel(const ChannelRequest& request);

}  // namespace gyrobench::calibration
