// A channel's g-sensitivity, whether the model names it or not.
#pragma once

#include "calibration/sensor/make_vector.h"
#include "calibration/trace/channel_fit.h"
#include "calibration/trace/problem.h"
#include "calibration/trace/selection.h"

namespace gyrobench::calibration {

// The members' own numbers where the model has bias.g_linear. Otherwise by one more fit with its
// three columns next to the model, under the same noise. An element that the model explains just as
// well, or whose standard error is beyond the largest size that such parts show, is not known.
// `grow`: what standard errors are multiplied by.
GravityRow FitGravityRow(const ChannelProblem& problem, const Selection& selection,
                         const ChannelFit& fit, double grow);

}  // namespace gyrobench::calibration
