// One channel from problem to verdict, and the uncertainty of the reference itself in what a trace
// says.
#pragma once

#include <span>
#include <vector>

#include "calibration/effects/channel_model.h"
#include "calibration/sensor/make_vector.h"
#include "calibration/trace/bench_finding.h"
#include "calibration/trace/trace_result.h"

namespace gyrobench::calibration {

struct ChannelRequest;
struct StateHistory;

struct TracedChannel {
  ChannelTrace trace;
  ChannelModel model;
  ChannelRow row;  // for the three axes together
  BenchFindings bench_findings;
};

TracedChannel TraceChannel(const ChannelRequest& request);

// Adds it (calibration/reference_error.h) to the errors of the channel's scale factor and
// cross-axis parts, in what the trace, the model and the row for the matrix say of them, the
// model's covariance among them. The eccentricity of the certificate is left out where the channel
// found an eccentricity and took it off. Where one of the inputs with a reference says nothing of
// it, nothing is added.
void AddReferenceError(std::span<const StateHistory> histories, std::size_t channel,
                       TracedChannel* traced);

// Fills TraceResult::reference_error and reference_uncertainty.
void DescribeReferenceError(std::span<const StateHistory> histories, TraceResult* result);

}  // namespace gyrobench::calibration
