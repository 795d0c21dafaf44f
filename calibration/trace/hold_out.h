// What a model is worth on data that its fit did not see.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <vector>

#include "calibration/trace/channel_fit.h"
#include "calibration/trace/problem.h"
#include "calibration/trace/trace_result.h"

namespace gyrobench::calibration {

// Whitened RMS and angle error on data that the fit did not see: by whole measurements where there
// are three and more, and none of them alone knows what a column does; else ten times a tenth of
// short blocks in time, which cover what the rest of the blocks do. `without`: columns of `fit.raw`
// that the model before leaves out; the model after has all. NaN where the data are too short to be
// divided. Where a step, a tone or a curve's bend was placed all data have had their say: only
// sizes, shapes and constants are trained anew.
struct HeldOutFigures {
  HeldOut whitened_rms, angle_rms_deg;
};
HeldOutFigures HoldOut(const ChannelProblem& problem, const ChannelFit& fit,
                       const std::vector<Eigen::Index>& without, std::uint64_t seed);
// The angle error, trained on the first 60 % of the time and tested on the rest. The bias goes on
// where the noise says that it has walked to.
HeldOut Forecast(const ChannelProblem& problem, const ChannelFit& fit, const IntervalNoise& noise,
                 std::uint64_t seed);

}  // namespace gyrobench::calibration
