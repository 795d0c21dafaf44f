// One channel from problem to verdict, and the uncertainty of the reference itself in what a trace
// says.
#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "calibration/effects/channel_model.h"
#include "calibration/sensor/make_vector.h"
#include "calibration/trace/bench_finding.h"
#include "calibration/trace/between_samples.h"
#include "calibration/trace/misread_axis.h"
#include "calibration/trace/reference_angle_error.h"
#include "calibration/trace/trace_result.h"

namespace gyrobench::calibration {

struct ChannelRequest;
struct StateHistory;

struct TracedChannel {
  ChannelTrace trace;
  ChannelModel model;
  ChannelRow row;  // for the three axes together
  BenchFindings bench_findings;
  std::shared_ptr<const ReferenceAngleError> angle_error;  // about its axis
  std::vector<MisreadAxis> misread;                        // as it says for others
  Sampling sampling;
};

// The parts of one channel's trace. The request must outlive them.
class ChannelTracer {
 public:
  // Makes what the searches share.
  explicit ChannelTracer(const ChannelRequest& request);
  ~ChannelTracer();

  // SamplingMend of the channel. nullopt where it cannot tell what the samples are.
  std::optional<SamplingSeen> LookAtSamples() const;
  // Once, before the searches.
  void MendBetweenSamples(const Sampling& sampling);

  // The search on all data and those on parts of them, to be called once each, in any order and
  // side by side: none sees what another one finds. The longest one first.
  std::vector<std::function<void()>> Searches();
  // When all of them are done.
  TracedChannel Finish();

 private:
  class State;
  std::unique_ptr<State> state_;
};

// Adds what the Earth's rotation may be of a g-sensitivity in the model (GravityRow) to its errors
// in the trace and to its block of the model's covariance. What it may be of the offset, and their
// covariance, are not counted.
void AddEarthError(TracedChannel* traced);

// Adds the reference's uncertainty (calibration/signal/reference_error.h) to the errors of the
// channel's scale factor and cross-axis parts, in what the trace, the model and the row for the
// matrix say of them, the model's covariance among them. The eccentricity of the certificate is
// left out where the channel found an eccentricity and took it off. Where one of the inputs with a
// reference says nothing of it, nothing is added.
void AddReferenceError(std::span<const StateHistory> histories, std::size_t channel,
                       TracedChannel* traced);

// Fills TraceResult::reference_error and reference_uncertainty.
void DescribeReferenceError(std::span<const StateHistory> histories, TraceResult* result);

}  // namespace gyrobench::calibration
