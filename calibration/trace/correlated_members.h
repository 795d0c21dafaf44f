// What an effect gains beside a residual that is not white.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "calibration/gls/correlated.h"
#include "calibration/trace/channel_fit.h"
#include "calibration/trace/problem.h"

namespace gyrobench::calibration {

// Of the columns `own` beside the others of the fit: what they gain of -2 log L with errors that
// allow for residuals that belong together, the least over every distance at which whiteness is
// tested.
CorrelatedGain LeastWhereCorrelated(const ChannelProblem& problem, const ChannelFit& fit,
                                    const std::vector<Eigen::Index>& own);

}  // namespace gyrobench::calibration
