// One channel from problem to verdict.
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "calibration/trace/channel_model.h"
#include "calibration/trace/trace_result.h"
#include "calibration/trace/trail.h"

namespace gyrobench::calibration {

struct ChannelRequest {
  std::span<const Trail> trails;
  std::size_t channel = 2;
  double units_per_deg_s = 1.0;
  std::vector<std::string> covariates;
  bool earth_rate_known = false;
  double false_discovery = 0.001;
  std::uint64_t seed = 1;
  bool curves = true;
};

struct TracedChannel {
  ChannelTrace trace;
  ChannelModel model;
};

TracedChannel TraceChannel(const ChannelRequest& request);

}  // namespace gyrobench::calibration
