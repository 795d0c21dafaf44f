// What still speaks in the residual after the effects.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "calibration/trace/channel_fit.h"
#include "calibration/trace/problem.h"
#include "calibration/trace/trace_result.h"

namespace gyrobench::calibration {

// Rows that are summed before their serial correlations are tested, at up to ten of such sums.
inline constexpr Eigen::Index kWhitenessBlocks[] = {1, 10, 100};
// Whether there are enough rows for it, and more than the sensor's own filter would show.
bool WhitenessIsTested(const ChannelProblem& problem, Eigen::Index block);

// Whiteness, dependence on a covariate (binned means), variance against acceleration; Holm's
// correction over all of them, at 1 %. Findings that pass it.
ChannelTrace::Remaining WhatRemains(const ChannelProblem& problem, const ChannelFit& fit,
                                    const std::vector<std::string>& covariates);

}  // namespace gyrobench::calibration
