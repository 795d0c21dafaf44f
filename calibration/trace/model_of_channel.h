// A channel's fit as the model that is written down and applied.
#pragma once

#include <string>
#include <vector>

#include "calibration/effects/channel_model.h"
#include "calibration/trace/trace_result.h"

namespace gyrobench::calibration {

struct Baseline;
struct Candidate;
struct ChannelFit;
class ChannelProblem;
class Selection;

// Where a run is a parameter of the effect, it is called by its number as the measurements were
// given; within the trace it is its place among the runs.
Candidate AsGiven(const ChannelProblem& problem, Candidate member);

struct FittedChannel {
  const ChannelProblem& problem;
  const Baseline& baseline;
  const Selection& selection;
  const ChannelFit& fit;
  const std::vector<std::string>& covariates;
};

// Coefficients, terms, names with covariance, and where the data were; `model` has the axis and the
// units already. `baseline`: the parameters of the fit's first columns, in their order. Returns of
// each term of the model the effect that it is of. Throws std::logic_error where there is not one
// name for each parameter of the fit.
std::vector<std::size_t> FillModel(const FittedChannel& channel,
                                   const std::vector<ModelParameter>& baseline,
                                   ChannelModel* model);

}  // namespace gyrobench::calibration
