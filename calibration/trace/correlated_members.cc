#include <algorithm>
#include <cmath>
#include <cstddef>
#include <map>
#include <vector>

#include "base/geometry.h"
#include "calibration/gls/scaled_ldlt.h"
#include "calibration/trace/channel_fit.h"
#include "calibration/trace/remaining.h"
#include "calibration/trace/selection.h"

namespace gyrobench::calibration {
namespace {

std::vector<Eigen::Index> UnbrokenRuns(const ChannelProblem& problem) {
  std::vector<Eigen::Index> begins;
  for (Eigen::Index i = 0; i < problem.rows(); ++i) {
    const Interval& interval = problem.intervals()[static_cast<std::size_t>(i)];
    if (i == 0 || interval.new_run || interval.gap_before_s > interval.duration_s)
      begins.push_back(i);
  }
  return begins;
}

// Rounding is a function of the angle, and errs by the
// same each time that a motion is made again from the same place. So rows in which the axis turns
// are in one cluster where its angle is within some steps of its encoder, whatever turn and
// measurement they are of. Every other row is alone in its cluster.
std::vector<std::size_t> ClustersByPlace(const ChannelProblem& problem, std::size_t axis) {
  constexpr double kSteps = 8.0;
  const double step_deg = problem.LargestStep_deg(axis);
  const double places = std::max(1.0, std::round(kFullTurn_deg / (kSteps * step_deg)));
  std::map<double, std::size_t> at_place;
  std::vector<std::size_t> clusters;
  std::size_t count = 0;
  for (Eigen::Index i = 0; i < problem.rows(); ++i) {
    // In the middle between the two readings: there and back are one place.
    const SensorState &before = problem.half(i, 0), &after = problem.half(i, 1);
    const double turns = 0.5 * (before.table_deg[axis] + after.table_deg[axis]) / kFullTurn_deg;
    const bool turning = before.table_rate_deg_s[axis] != 0.0;
    std::size_t cluster = count;
    if (step_deg > 0.0 && turning && std::isfinite(turns)) {
      // A turn begins in the middle of a place.
      const double place = std::floor(places * (turns - std::floor(turns)) + 0.5);
      cluster = at_place.try_emplace(std::fmod(place, places), count).first->second;
    }
    clusters.push_back(cluster);
    count = std::max(count, cluster + 1);
  }
  return clusters;
}

}  // namespace

RowsTogether FindRowsTogether(const ChannelProblem& problem) {
  RowsTogether out{UnbrokenRuns(problem), {}};
  for (std::size_t axis = 0; problem.rounding_deg() > 0.0 && axis < 3; ++axis)
    out.clusters.push_back(ClustersByPlace(problem, axis));
  return out;
}

CorrelatedGain LeastWhereCorrelated(const ChannelProblem& problem, const RowsTogether& together,
                                    const ChannelFit& fit, const std::vector<Eigen::Index>& own) {
  const Projection others_off(fit.white(Eigen::all, fit.ColumnsBut(own)));
  const Eigen::MatrixXd whole = fit.white(Eigen::all, own);
  Eigen::MatrixXd left = others_off.Off(whole);
  for (Eigen::Index j = 0; j < left.cols(); ++j) {
    if (!(left.col(j).squaredNorm() > Selection::kAbsorbed * whole.col(j).squaredNorm()))
      left.col(j).setZero();
  }
  const Eigen::VectorXd output = others_off.Off(fit.white_output), residual = fit.WhiteResidual();
  std::vector<CorrelatedGain> gains;
  for (const Eigen::Index block : kWhitenessBlocks) {
    if (WhitenessIsTested(problem, block))
      gains.push_back(GainWhereCorrelated(left, output, residual, together.run_begins, block));
  }
  for (const std::vector<std::size_t>& clusters : together.clusters)
    gains.push_back(GainWhereClustered(left, output, residual, clusters));
  return gains.empty() ? CorrelatedGain{}
                       : *std::ranges::min_element(gains, {}, &CorrelatedGain::gain);
}

}  // namespace gyrobench::calibration
