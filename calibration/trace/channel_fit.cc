#include "calibration/trace/channel_fit.h"

#include <algorithm>
#include <cmath>

#include "calibration/trace/append_columns.h"
#include "calibration/trace/noise_search.h"
#include "calibration/trace/refine.h"
#include "calibration/trace/scaled_ldlt.h"

namespace gyrobench::calibration {
namespace {

constexpr double kLeastScale = 1e-3;
constexpr double kSlopeStep = 1e-4;  // of a parameter's range

// d(columns c) / d theta of each non-linear parameter: rows x parameters.
Eigen::MatrixXd Slopes(const ChannelProblem& problem, const Selection& selection,
                       const Candidate& member, const Eigen::VectorXd& coefficients) {
  if (!member.searched()) return Eigen::MatrixXd(problem.rows(), 0);
  const RefineRange range = *RangeOf(problem, member);
  Eigen::MatrixXd out(problem.rows(), static_cast<Eigen::Index>(range.start.size()));
  for (std::size_t k = 0; k < range.start.size(); ++k) {
    Candidate above = member, below = member;
    const double step = kSlopeStep * (range.high[k] - range.low[k]);
    above.context.nonlinear[k] += step;
    below.context.nonlinear[k] -= step;
    above.raw = below.raw = nullptr;
    out.col(static_cast<Eigen::Index>(k)) = (ColumnsOf(problem, above, selection.covariates()) -
                                             ColumnsOf(problem, below, selection.covariates())) *
                                            coefficients / (2.0 * step);
  }
  return out;
}

// Inverse of a matrix of products; 0 and NaN on the diagonal for columns that depend on others.
Eigen::MatrixXd CovarianceOf(const Eigen::MatrixXd& gram) {
  const std::vector<Eigen::Index> kept = IndependentColumns(gram);
  Eigen::MatrixXd out = Eigen::MatrixXd::Zero(gram.rows(), gram.cols());
  out.diagonal().setConstant(kMissing);
  const auto count = static_cast<Eigen::Index>(kept.size());
  out(kept, kept) = ScaledLdlt(gram(kept, kept)).Solve(Eigen::MatrixXd::Identity(count, count));
  return out;
}

// An angle or a delay is seen through the gyro's scale factor; what is stated is the angle and the
// delay.
void StateInReferenceScale(const ChannelProblem& problem, const Baseline& baseline,
                           const Selection& selection, ChannelFit* fit) {
  const auto own = std::find(baseline.turned.begin(), baseline.turned.end(), problem.channel());
  if (own == baseline.turned.end()) return;
  const double m = fit->linear(own - baseline.turned.begin());
  if (std::fabs(m) < kLeastScale) return;
  for (std::size_t i = 0; i < selection.members().size(); ++i) {
    const Candidate& member = selection.members()[i];
    if (member.effect == nullptr || member.effect->domain != EffectDomain::kAngle) continue;
    const auto count = static_cast<Eigen::Index>(member.columns.size());
    fit->values.segment(fit->member_begin[i], count) /= m;
    fit->covariance.middleRows(fit->member_begin[i], count) /= m;
    fit->covariance.middleCols(fit->member_begin[i], count) /= m;
  }
}

}  // namespace

double ChannelFit::whitened_rms() const {
  return std::sqrt(WhiteResidual().squaredNorm() / static_cast<double>(white_output.size()));
}

std::vector<Eigen::Index> ChannelFit::ColumnsOf(std::size_t member) const {
  const Eigen::Index end = member + 1 < column_begin.size() ? column_begin[member + 1] : raw.cols();
  std::vector<Eigen::Index> columns;
  for (Eigen::Index j = column_begin[member]; j < end; ++j) columns.push_back(j);
  return columns;
}

ChannelFit FitChannel(const ChannelProblem& problem, const Baseline& baseline,
                      const Selection& selection) {
  ChannelFit fit;
  const WhiteStore::Columns columns = selection.ModelColumns();
  fit.linear = selection.store().Solve(columns);
  fit.white = selection.store().Take(columns);
  fit.white_output = selection.store().output();
  fit.baseline_columns = static_cast<Eigen::Index>(selection.baseline_columns().size());
  const auto turned = static_cast<Eigen::Index>(baseline.turned.size());
  fit.local.assign(static_cast<std::size_t>(fit.white.cols()), false);
  std::fill_n(fit.local.begin() + turned, baseline.constants, true);
  fit.raw.resize(problem.rows(), fit.white.cols());
  fit.raw.leftCols(fit.baseline_columns) = baseline.columns;
  fit.raw_slopes.resize(problem.rows(), 0);
  fit.white_slopes.resize(problem.rows(), 0);
  Eigen::MatrixXd tangent = fit.white.leftCols(fit.baseline_columns);
  std::vector<double> values(fit.linear.data(), fit.linear.data() + fit.baseline_columns);
  Eigen::Index column = fit.baseline_columns;
  for (const Candidate& member : selection.members()) {
    const auto count = static_cast<Eigen::Index>(member.columns.size());
    fit.column_begin.push_back(column);
    fit.member_begin.push_back(tangent.cols());
    fit.slope_begin.push_back(fit.raw_slopes.cols());
    fit.raw.middleCols(column, count) = ColumnsOf(problem, member, selection.covariates());
    // One power-on alone knows it, or one moment.
    if (member.power_on || member.id == "angle.step")
      std::fill_n(fit.local.begin() + column, count, true);
    const Eigen::VectorXd c = fit.linear.segment(column, count);
    const Eigen::MatrixXd raw_slopes = Slopes(problem, selection, member, c);
    Eigen::MatrixXd white_slopes = raw_slopes;
    selection.whitener().Apply(white_slopes);
    AppendColumns(&fit.raw_slopes, raw_slopes);
    AppendColumns(&fit.white_slopes, white_slopes);
    AppendColumns(&tangent, fit.white.middleCols(column, count));
    AppendColumns(&tangent, white_slopes);
    values.insert(values.end(), c.data(), c.data() + count);
    if (raw_slopes.cols() > 0) {
      values.insert(values.end(), member.context.nonlinear.begin(), member.context.nonlinear.end());
    }
    column += count;
  }
  fit.values = Eigen::Map<Eigen::VectorXd>(values.data(), static_cast<Eigen::Index>(values.size()));
  fit.covariance = CovarianceOf(tangent.transpose() * tangent);
  StateInReferenceScale(problem, baseline, selection, &fit);
  return fit;
}

}  // namespace gyrobench::calibration
