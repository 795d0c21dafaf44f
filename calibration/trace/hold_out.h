// What a chosen model is worth on data that the coefficients which all measurements share did not
// see.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <vector>

#include "calibration/trace/channel_fit.h"
#include "calibration/trace/held_out.h"
#include "calibration/trace/problem.h"

namespace gyrobench::calibration {

// Whitened RMS and angle error on data that the coefficients did not see: by whole measurements
// where there are three and more, and none of them alone knows what a column does; else ten times a
// tenth of short blocks in time, which cover what the rest of the blocks do. Blocks that know more
// of a column than the rest, as of a resonance that is passed once, have a tenth of their weight in
// the coefficients. What acts in the held-out rows alone, as a step of the angle, a delay of one
// run or the constant of one power-on, no other row knows: its size is what these rows say of it,
// so that of such an effect the figures say how well it describes them, and foretell nothing.
// `without`: columns of `fit.raw` that the model before leaves out; the model
// after has all. NaN where the data are too short to be divided. Which effects there are, where a
// step, a tone or a curve's bend is, and the noise, was chosen on all data: only sizes, shapes and
// constants are trained anew. PartTrial has the choice on a part as well.
HeldOutFigures HoldOut(const ChannelProblem& problem, const ChannelFit& fit,
                       const std::vector<Eigen::Index>& without, std::uint64_t seed);

}  // namespace gyrobench::calibration
