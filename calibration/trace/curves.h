// What the report draws: residuals before and after, spectrum, Allan deviation.
#pragma once

#include "calibration/gls/interval_gls.h"
#include "calibration/trace/channel_fit.h"
#include "calibration/trace/problem.h"
#include "calibration/trace/selection.h"
#include "calibration/trace/trace_result.h"

namespace gyrobench::calibration {

ResidualCurves MakeCurves(const ChannelProblem& problem, const ChannelFit& fit,
                          const Selection& selection, const IntervalNoise& noise);

}  // namespace gyrobench::calibration
