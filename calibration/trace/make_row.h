// A channel's part in the three axes, from its fit.
#pragma once

#include "calibration/sensor/make_vector.h"
#include "calibration/trace/channel_fit.h"
#include "calibration/trace/problem.h"
#include "calibration/trace/selection.h"

namespace gyrobench::calibration {

// Row of M, parameters that other channels may feel as well, and g-sensitivity; `unit` and
// `units_per_deg_s` are left to the caller. `grow`: what standard errors are multiplied by.
ChannelRow MakeChannelRow(const ChannelProblem& problem, const Baseline& baseline,
                          const Selection& selection, const ChannelFit& fit, double grow);

}  // namespace gyrobench::calibration
