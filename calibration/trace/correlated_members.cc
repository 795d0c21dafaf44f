#include <algorithm>
#include <cstddef>
#include <vector>

#include "calibration/gls/scaled_ldlt.h"
#include "calibration/trace/channel_fit.h"
#include "calibration/trace/reference_rounding.h"
#include "calibration/trace/remaining.h"
#include "calibration/trace/selection.h"

namespace gyrobench::calibration {
namespace {

// First rows of stretches without a gap.
std::vector<Eigen::Index> UnbrokenRuns(const ChannelProblem& problem) {
  std::vector<Eigen::Index> begins;
  for (Eigen::Index i = 0; i < problem.rows(); ++i) {
    const Interval& interval = problem.intervals()[static_cast<std::size_t>(i)];
    if (i == 0 || interval.new_run || interval.gap_before_s > interval.duration_s)
      begins.push_back(i);
  }
  return begins;
}

}  // namespace

CorrelatedGain LeastWhereCorrelated(const ChannelProblem& problem, const ChannelFit& fit,
                                    const std::vector<Eigen::Index>& own) {
  const Projection others_off(fit.white(Eigen::all, fit.ColumnsBut(own)));
  const Eigen::MatrixXd whole = fit.white(Eigen::all, own);
  Eigen::MatrixXd left = others_off.Off(whole);
  for (Eigen::Index j = 0; j < left.cols(); ++j) {
    if (!(left.col(j).squaredNorm() > Selection::kAbsorbed * whole.col(j).squaredNorm()))
      left.col(j).setZero();
  }
  const Eigen::VectorXd output = others_off.Off(fit.white_output), residual = fit.WhiteResidual();
  const std::vector<Eigen::Index> runs = UnbrokenRuns(problem);
  std::vector<CorrelatedGain> gains;
  for (const Eigen::Index block : kWhitenessBlocks) {
    if (WhitenessIsTested(problem, block))
      gains.push_back(GainWhereCorrelated(left, output, residual, runs, block));
  }
  for (const std::size_t axis : problem.table_axes()) {
    if (problem.rounding_wave_deg(axis) > 0.0)
      gains.push_back(GainWhereClustered(left, output, residual, PlacesOfEncoder(problem, axis)));
  }
  return gains.empty() ? CorrelatedGain{}
                       : *std::ranges::min_element(gains, {}, &CorrelatedGain::gain);
}

}  // namespace gyrobench::calibration
