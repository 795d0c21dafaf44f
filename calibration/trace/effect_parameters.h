// The parameters of a fit as they are reported.
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <string>
#include <vector>

#include "calibration/trace/candidate.h"
#include "calibration/trace/channel_fit.h"
#include "calibration/trace/trace_result.h"

namespace gyrobench::calibration {

// The j-th of the fit; its standard error is `grow` times its bound.
ModelParameter Parameter(const ChannelFit& fit, Eigen::Index j, std::string name, std::string unit,
                         double grow);
// Of the member with that index: its coefficients, a sine and a cosine as amplitude and phase, and
// its non-linear parameters, those without a standard error that a scan or a grid has placed.
std::vector<ModelParameter> EffectParameters(const Candidate& member, const ChannelFit& fit,
                                             std::size_t index, double grow,
                                             const std::vector<std::string>& covariates);

}  // namespace gyrobench::calibration
