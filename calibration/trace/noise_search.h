// Noise of a problem by restricted maximum likelihood, under a model that leaves nothing out.
#pragma once

#include <Eigen/Core>
#include <optional>
#include <span>
#include <vector>

#include "calibration/interval_gls.h"

namespace gyrobench::calibration {

// `columns`: rows x p, everything that may act, dependent ones allowed; a missing effect would
// otherwise pass for noise. `start`: where to begin, when something is known. N in closed form, K/N
// and s/N by search; stretches at rest are taken second by second, which changes nothing that N and
// K could be told from. nullopt with fewer rows than columns.
std::optional<IntervalNoise> SearchNoise(std::span<const Interval> intervals,
                                         const Eigen::MatrixXd& columns,
                                         const Eigen::VectorXd& output,
                                         const std::optional<IntervalNoise>& start = {});

// Those of the columns that are independent of the ones before them, `gram` being their products.
std::vector<Eigen::Index> IndependentColumns(const Eigen::MatrixXd& gram, double tolerance = 1e-9);

}  // namespace gyrobench::calibration
