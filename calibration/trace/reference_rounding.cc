#include "calibration/trace/reference_rounding.h"

#include <algorithm>
#include <cmath>
#include <map>

#include "base/geometry.h"
#include "calibration/gls/noise_search.h"
#include "calibration/gls/raw_columns.h"
#include "calibration/trace/channel_fit.h"
#include "calibration/trace/problem.h"
#include "calibration/trace/remaining.h"
#include "calibration/trace/selection.h"

namespace gyrobench::calibration {

std::vector<std::size_t> PlacesOfEncoder(const ChannelProblem& problem, std::size_t axis) {
  constexpr double kSteps = 8.0;
  std::map<double, std::size_t> at_place;
  std::vector<std::size_t> cluster;
  std::size_t clusters = 0;
  for (Eigen::Index i = 0; i < problem.rows(); ++i) {
    const double step_deg = problem.history(i).rest_flicker[axis].step_deg;
    const double angle_deg = problem.end_node(i).table_deg[axis];
    const double turn = angle_deg / kFullTurn_deg;
    const bool rounded =
        step_deg > 0.0 && std::isfinite(turn) && problem.half(i, 0).table_rate_deg_s[axis] != 0.0;
    const double place =
        std::floor(kFullTurn_deg * (turn - std::floor(turn)) / (kSteps * step_deg));
    cluster.push_back(rounded ? at_place.try_emplace(place, clusters).first->second : clusters);
    clusters = std::max(clusters, cluster.back() + 1);
  }
  return cluster;
}

std::optional<NoiseModel> NoiseWithRounding(const ChannelProblem& problem, const Baseline& baseline,
                                            const Selection& selection, const NoiseModel& noise) {
  if (!(problem.rounding_deg() > 0.0) || !selection.members().empty()) return std::nullopt;
  const ChannelTrace::Remaining remains =
      WhatRemains(problem, FitChannel(problem, baseline, selection), selection.covariates());
  if (remains.white || !remains.findings.empty()) return std::nullopt;
  const NoiseSearch search(problem.intervals(), {RawColumns(baseline.columns)}, problem.output_deg());
  const std::optional<NoiseEstimate> best = search.Best(noise);
  return best ? std::optional<NoiseModel>(best->noise) : std::nullopt;
}

}  // namespace gyrobench::calibration
