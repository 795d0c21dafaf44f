// From measurements to a verdict: baseline, residual, effects, and the error before and after.
#pragma once

#include <cstdint>
#include <functional>
#include <span>
#include <string>
#include <vector>

#include "calibration/effects/channel_model.h"
#include "calibration/signal/collector.h"
#include "calibration/trace/trace_result.h"

namespace gyrobench::calibration {

struct TraceOptions {
  // Of everything that bootstraps and resamples. The same data, options and seed give the same
  // result, to the last digit.
  std::uint64_t seed = 1;
  // Chance that a measurement without any extra effect is said to have one, over all channels.
  double false_discovery = 0.009;
  bool curves = true;  // fill ChannelTrace::curves
  // Choose on parts of the data as well, and try that on the rest: what is held out, and the
  // forecast. Takes as long again.
  bool try_on_rest = true;
  // Called now and then with the share done, 0..1.
  std::function<void(double fraction)> progress;
};

// Traces one sensor through one or many measurements (runs of one sensor are one problem). What
// cannot be estimated is said in remarks, and the channel's verdict is for what can. Throws
// DataError when there is nothing to analyse at all: no sample, or no usable one on any axis.
struct Traced {
  TraceResult result;
  std::vector<ChannelModel> models;  // in the order of result.channels
};
Traced Trace(std::span<const Recording* const> recordings, const TraceOptions& options = {});

}  // namespace gyrobench::calibration
