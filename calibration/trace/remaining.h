// What still speaks in the residual after the effects, what an effect gains beside a residual that
// is not white, and the noise that such a residual has.
#pragma once

#include <Eigen/Core>
#include <optional>
#include <string>
#include <vector>

#include "calibration/gls/noise_model.h"
#include "calibration/gls/robust_gain.h"
#include "calibration/trace/trace_result.h"

namespace gyrobench::calibration {

struct Baseline;
struct ChannelFit;
class ChannelProblem;
class Selection;

// Rows that are summed before their serial correlations are tested, at up to ten of such sums.
inline constexpr Eigen::Index kWhitenessBlocks[] = {1, 10, 100};
// Whether there are enough rows for it, and more than the sensor's own filter would show.
bool WhitenessIsTested(const ChannelProblem& problem, Eigen::Index block);

// Whiteness, dependence on a covariate (binned means), variance against acceleration; Holm's
// correction over all of them, at 1 %. Findings that pass it.
ChannelTrace::Remaining WhatRemains(const ChannelProblem& problem, const ChannelFit& fit,
                                    const std::vector<std::string>& covariates);

// Which residuals of a problem may belong together, whatever is fitted to it.
struct RowsTogether {
  std::vector<Eigen::Index> run_begins;            // first rows of stretches without a gap
  std::vector<std::vector<std::size_t>> clusters;  // for GainWhereClustered, by stand axis
};
RowsTogether FindRowsTogether(const ChannelProblem& problem);
// Of the columns `own` beside the others of the fit: what they gain of -2 log L with errors that
// allow for such residuals, the least over every distance at which whiteness is tested, and over
// the axes.
CorrelatedGain LeastWhereCorrelated(const ChannelProblem& problem, const RowsTogether& together,
                                    const ChannelFit& fit, const std::vector<Eigen::Index>& own);

// The noise that is estimated beside everything that may act is too small where rounding remains,
// because all of that together fits a part of the rounding. Where nothing was chosen and rounding
// alone remains, this is the noise beside the baseline alone, searched from `noise`; else nullopt.
std::optional<NoiseModel> NoiseWithRounding(const ChannelProblem& problem, const Baseline& baseline,
                                            const Selection& selection, const NoiseModel& noise);

}  // namespace gyrobench::calibration
