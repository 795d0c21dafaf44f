#include "calibration/gls/noise_search.h"
#include "calibration/trace/channel_fit.h"
#include "calibration/trace/problem.h"
#include "calibration/trace/remaining.h"
#include "calibration/trace/selection.h"

namespace gyrobench::calibration {

std::optional<NoiseModel> NoiseWithRounding(const ChannelProblem& problem, const Baseline& baseline,
                                            const Selection& selection, const NoiseModel& noise) {
  constexpr double kTooSmall = 1.05;  // of the white residual, in the root mean square
  if (!(problem.rounding_deg() > 0.0) || !selection.members().empty()) return std::nullopt;
  const ChannelFit fit = FitChannel(problem, baseline, selection);
  if (!(fit.whitened_rms() > kTooSmall)) return std::nullopt;
  const ChannelTrace::Remaining remains = WhatRemains(problem, fit, selection.covariates());
  if (remains.white || !remains.findings.empty()) return std::nullopt;
  const NoiseSearch search(problem.intervals(), RawBaseline(baseline), problem.output_deg());
  const std::optional<NoiseEstimate> best = search.Best(noise);
  return best ? std::optional<NoiseModel>(search.WithMeanWalk(*best).noise) : std::nullopt;
}

}  // namespace gyrobench::calibration
