#include "calibration/trace/channel_fit.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "calibration/gls/independent_columns.h"
#include "calibration/gls/raw_columns.h"
#include "calibration/gls/scaled_ldlt.h"
#include "calibration/trace/refine.h"
#include "calibration/trace/selection.h"

namespace gyrobench::calibration {
namespace {

constexpr double kSlopeStep = 1e-4;  // of a parameter's range

// d(columns c) / d theta of each non-linear parameter: rows x parameters. `columns_of`: of a
// candidate, such rows.
template <typename ColumnsOfCandidate>
Eigen::MatrixXd Slopes(const ChannelProblem& problem, const Candidate& member,
                       const Eigen::VectorXd& coefficients, Eigen::Index rows,
                       ColumnsOfCandidate columns_of) {
  if (!member.shape_is_free()) return Eigen::MatrixXd(rows, 0);
  const RefineRange range = *RangeOf(problem, member);
  Eigen::MatrixXd out(rows, static_cast<Eigen::Index>(range.start.size()));
  for (std::size_t k = 0; k < range.start.size(); ++k) {
    Candidate above = member, below = member;
    const double step = kSlopeStep * (range.high[k] - range.low[k]);
    std::vector<double> theta = range.start;
    theta[k] += step;
    SetNonlinear(theta, &above);
    theta[k] -= 2.0 * step;
    SetNonlinear(theta, &below);
    out.col(static_cast<Eigen::Index>(k)) =
        (columns_of(above) - columns_of(below)) * coefficients / (2.0 * step);
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
  if (std::fabs(m) < kLeastScaleFactor) return;
  for (std::size_t i = 0; i < selection.members().size(); ++i) {
    const Candidate& member = selection.members()[i];
    if (member.effect == nullptr || member.effect->domain != EffectDomain::kAngle) continue;
    const auto count = static_cast<Eigen::Index>(member.columns.size());
    fit->values.segment(fit->member_begin[i], count) /= m;
    fit->covariance.middleRows(fit->member_begin[i], count) /= m;
    fit->covariance.middleCols(fit->member_begin[i], count) /= m;
    fit->by_misread.middleRows(fit->member_begin[i], count) /= m;
  }
}

// What others found of misread axes has an error, which is in what is fitted to the rest. Of what
// the data do not tell the covariance says so on its diagonal alone, and it stays so.
void AddMisread(const ChannelProblem& problem, const Selection& selection,
                const Eigen::MatrixXd& tangent, ChannelFit* fit) {
  Eigen::MatrixXd deviations = problem.MisreadDeviations();
  fit->by_misread = Eigen::MatrixXd::Zero(fit->covariance.rows(), deviations.cols());
  if (deviations.cols() == 0) return;
  selection.whitener().Apply(deviations);
  const Eigen::MatrixXd known =
      fit->covariance.unaryExpr([](double value) { return std::isfinite(value) ? value : 0.0; });
  fit->by_misread = known * (tangent.transpose() * deviations);
  fit->covariance += fit->by_misread * fit->by_misread.transpose();
}

// What the rows of single readings say of the members, and the priors of misread places.
void AddMoreRows(const ChannelProblem& problem, const Selection& selection, ChannelFit* fit) {
  const Eigen::Index linear = fit->white.cols(), all = linear + fit->white_slopes.cols();
  const Eigen::VectorXd output = selection.OutputOfReadings();
  fit->more_products = Eigen::MatrixXd::Zero(all, all);
  fit->more_with_output = Eigen::VectorXd::Zero(all);
  Eigen::MatrixXd rows(output.size(), 0);
  std::vector<Eigen::Index> places;
  for (std::size_t i = 0; i < selection.members().size(); ++i) {
    const Candidate& member = selection.members()[i];
    const Eigen::MatrixXd columns = selection.ColumnsOfReadings(member);
    if (columns.cols() == 0) continue;
    AppendColumns(&rows, columns);
    AppendColumns(&rows,
                  Slopes(problem, member, fit->linear.segment(fit->column_begin[i], columns.cols()),
                         rows.rows(),
                         [&](const Candidate& near) { return selection.ColumnsOfReadings(near); }));
    const std::vector<Eigen::Index> own = fit->PlacesInMore(fit->ColumnsOf(i), fit->SlopesOf(i));
    places.insert(places.end(), own.begin(), own.end());
  }
  fit->more_products(places, places) = rows.transpose() * rows;
  fit->more_with_output(places) = rows.transpose() * output;
  fit->more_products.diagonal()
      .segment(fit->baseline_columns - fit->misread_places, fit->misread_places)
      .setOnes();
}

// They are no parameters of the sensor: what is not known of them is in the others' covariance.
void LeaveOutMisreadPlaces(ChannelFit* fit) {
  std::vector<Eigen::Index> kept;
  for (Eigen::Index j = 0; j < fit->values.size(); ++j) {
    if (j < fit->baseline_columns - fit->misread_places || j >= fit->baseline_columns)
      kept.push_back(j);
  }
  fit->values = Eigen::VectorXd(fit->values(kept));
  fit->covariance = Eigen::MatrixXd(fit->covariance(kept, kept));
  fit->by_misread = Eigen::MatrixXd(fit->by_misread(kept, Eigen::all));
  for (Eigen::Index& begin : fit->member_begin) begin -= fit->misread_places;
}

// From the begin of one member to that of the next.
std::vector<Eigen::Index> Owned(const std::vector<Eigen::Index>& begin, std::size_t member,
                                Eigen::Index all) {
  const Eigen::Index end = member + 1 < begin.size() ? begin[member + 1] : all;
  std::vector<Eigen::Index> out;
  for (Eigen::Index j = begin[member]; j < end; ++j) out.push_back(j);
  return out;
}

}  // namespace

double ChannelFit::whitened_rms() const {
  return std::sqrt(WhiteResidual().squaredNorm() / static_cast<double>(white_output.size()));
}

std::vector<Eigen::Index> ChannelFit::ColumnsOf(std::size_t member) const {
  return Owned(column_begin, member, raw.cols());
}

std::vector<Eigen::Index> ChannelFit::SlopesOf(std::size_t member) const {
  return Owned(slope_begin, member, raw_slopes.cols());
}

std::vector<Eigen::Index> ChannelFit::PlacesInMore(const std::vector<Eigen::Index>& columns,
                                                   const std::vector<Eigen::Index>& slopes) const {
  std::vector<Eigen::Index> out = columns;
  for (const Eigen::Index j : slopes) out.push_back(white.cols() + j);
  return out;
}

std::vector<Eigen::Index> ChannelFit::ColumnsBut(const std::vector<Eigen::Index>& without) const {
  std::vector<Eigen::Index> out;
  for (Eigen::Index j = 0; j < white.cols(); ++j) {
    if (std::find(without.begin(), without.end(), j) == without.end()) out.push_back(j);
  }
  return out;
}

ModelColumns ColumnsOfModel(const ChannelProblem& problem, const Baseline& baseline,
                            const std::vector<Candidate>& members,
                            const Eigen::VectorXd& coefficients,
                            const std::vector<std::string>& covariates) {
  ModelColumns out;
  out.linear.resize(problem.rows(), coefficients.size());
  Eigen::Index column = baseline.columns.cols();
  out.linear.leftCols(column) = baseline.columns;
  out.slopes.resize(problem.rows(), 0);
  for (const Candidate& member : members) {
    const auto count = static_cast<Eigen::Index>(member.columns.size());
    out.column_begin.push_back(column);
    out.slope_begin.push_back(out.slopes.cols());
    out.linear.middleCols(column, count) = ColumnsOf(problem, member, covariates);
    AppendColumns(&out.slopes, Slopes(problem, member, coefficients.segment(column, count),
                                      problem.rows(), [&](const Candidate& near) {
                                        return ColumnsOf(problem, near, covariates);
                                      }));
    column += count;
  }
  return out;
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
  fit.misread_places = baseline.misread_places;
  std::fill_n(fit.local.begin() + baseline.of_sensor(), fit.misread_places, true);
  ModelColumns raw =
      ColumnsOfModel(problem, baseline, selection.members(), fit.linear, selection.covariates());
  fit.raw = std::move(raw.linear);
  fit.raw_slopes = std::move(raw.slopes);
  fit.white_slopes = fit.raw_slopes;
  selection.whitener().Apply(fit.white_slopes);
  fit.column_begin = std::move(raw.column_begin);
  fit.slope_begin = std::move(raw.slope_begin);
  Eigen::MatrixXd tangent = fit.white.leftCols(fit.baseline_columns);
  std::vector<Eigen::Index> places_in_more(static_cast<std::size_t>(fit.baseline_columns));
  std::iota(places_in_more.begin(), places_in_more.end(), Eigen::Index{0});
  std::vector<double> values(fit.linear.data(), fit.linear.data() + fit.baseline_columns);
  for (std::size_t i = 0; i < selection.members().size(); ++i) {
    const Candidate& member = selection.members()[i];
    const Eigen::Index column = fit.column_begin[i];
    const auto count = static_cast<Eigen::Index>(member.columns.size());
    const std::vector<Eigen::Index> slopes = fit.SlopesOf(i);
    fit.member_begin.push_back(tangent.cols());
    // One power-on alone knows it, or one run, or one moment.
    if (member.power_on || member.of_one_run() || member.angle_step())
      std::fill_n(fit.local.begin() + column, count, true);
    AppendColumns(&tangent, fit.white.middleCols(column, count));
    AppendColumns(&tangent, fit.white_slopes(Eigen::all, slopes));
    for (const Eigen::Index place : fit.PlacesInMore(fit.ColumnsOf(i), slopes))
      places_in_more.push_back(place);
    for (Eigen::Index j = 0; j < count; ++j) values.push_back(fit.linear(column + j));
    if (!slopes.empty()) {
      values.insert(values.end(), member.context.nonlinear.begin(), member.context.nonlinear.end());
    }
  }
  fit.values = Eigen::Map<Eigen::VectorXd>(values.data(), static_cast<Eigen::Index>(values.size()));
  AddMoreRows(problem, selection, &fit);
  const Eigen::MatrixXd more = fit.more_products(places_in_more, places_in_more);
  fit.covariance = CovarianceOf(tangent.transpose() * tangent + more);
  AddMisread(problem, selection, tangent, &fit);
  LeaveOutMisreadPlaces(&fit);
  StateInReferenceScale(problem, baseline, selection, &fit);
  return fit;
}

}  // namespace gyrobench::calibration
