#include "calibration/trace/within_nodes.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <memory>
#include <utility>

#include "calibration/effects/basis.h"

namespace gyrobench::calibration {
namespace {

constexpr std::uint32_t kLeastReadings = 3;
constexpr double kLeastFreedom = 100.0;  // of a standard deviation that counts as known
// In standard deviations: a node with such a reading has a wild one.
constexpr double kWild = 6.0;
// Of the least step of the readings, in which errors that come of less noise go by the angle:
// sqrt(0.4^2 + 1/12), of noise of 0.4 of a step, of which rounding leaves a wave of 1.4 % of it.
constexpr double kDithered = 0.49;

// What the baseline has of a row beside its turns [deg].
double BesideTurns(const Baseline& baseline, const Eigen::VectorXd& fit, Eigen::Index row) {
  const auto turned = static_cast<Eigen::Index>(baseline.turned.size());
  const Eigen::Index rest = baseline.columns.cols() - turned;
  return baseline.columns.row(row).tail(rest).dot(fit.tail(rest));
}

}  // namespace

WithinNodes::WithinNodes(const ChannelProblem& problem, const Baseline& baseline,
                         const Eigen::VectorXd& fit, double walk_deg_sqrt_s)
    : problem_(&problem), walk_deg_sqrt_s_(walk_deg_sqrt_s) {
  std::vector<double> output;
  Collect(baseline, fit, &output);
  const std::vector<double> sigma_deg = ErrorsOfReadings(output);
  // Rows of what is left, in order.
  std::vector<double> after_s;
  std::vector<double> kept;
  std::vector<MovingNode> nodes;
  for (MovingNode node : nodes_) {
    const double sigma = sigma_deg[problem.row_refs()[static_cast<std::size_t>(node.row)].history];
    const double* own = output.data() + node.begin;
    const bool wild = std::any_of(own, own + node.count,
                                  [&](double off) { return std::fabs(off) > kWild * sigma; });
    if (!(sigma > 0.0) || wild) continue;
    const auto begin = static_cast<Eigen::Index>(kept.size());
    kept.insert(kept.end(), own, own + node.count);
    after_s.insert(after_s.end(), after_s_.begin() + node.begin,
                   after_s_.begin() + node.begin + node.count);
    node.begin = begin;
    node.white = WhiteningOf(node.count,
                             (after_s.back() - after_s[static_cast<std::size_t>(begin)]) /
                                 static_cast<double>(node.count - 1),
                             sigma);
    nodes.push_back(node);
  }
  nodes_ = std::move(nodes);
  after_s_ = std::move(after_s);
  output_.resize(static_cast<Eigen::Index>(kept.size()));
  for (const MovingNode& node : nodes_) {
    output_.segment(node.begin, node.count) =
        White(node) * Eigen::Map<const Eigen::VectorXd>(kept.data() + node.begin, node.count);
  }
}

void WithinNodes::Collect(const Baseline& baseline, const Eigen::VectorXd& fit,
                          std::vector<double>* output) {
  Vector3 m = {};
  m[problem_->channel()] = 1.0;
  for (std::size_t j = 0; j < baseline.turned.size(); ++j)
    m[baseline.turned[j]] = fit(static_cast<Eigen::Index>(j));
  const double units = problem_->units_per_deg_s();
  for (Eigen::Index i = 0; i < problem_->rows(); ++i) {
    const StateHistory& history = problem_->history(i);
    const Interval& interval = problem_->intervals()[static_cast<std::size_t>(i)];
    const Node& epoch = problem_->end_epoch(i);
    if (interval.still || !problem_->FeelsTable(i) || epoch.within_count < kLeastReadings ||
        epoch.at.t_s != epoch.mean.t_s)
      continue;
    const double offset_deg_s = BesideTurns(baseline, fit, i) / interval.duration_s;
    const ReadingWithin* reading = history.recording->columns.within.data() + epoch.within_begin;
    nodes_.push_back({i, static_cast<Eigen::Index>(output->size()), epoch.within_count, 0});
    for (std::uint32_t k = 0; k < epoch.within_count; ++k, ++reading) {
      const double after_s = static_cast<double>(reading->after_s);
      double off_deg =
          static_cast<double>(reading->z[problem_->channel()]) / units - offset_deg_s * after_s;
      for (std::size_t c = 0; c < 3; ++c)
        off_deg -= m[c] * static_cast<double>(reading->rotation_deg[c]);
      output->push_back(off_deg);
      after_s_.push_back(after_s);
    }
  }
}

// Of each measurement, by the scatter about the nodes' means less what the gyro's walk makes of it:
// twice, the second time without wild ones. 0 where nothing is to be had: of few readings, where
// rounding is no noise, and where the walk is as large as the errors.
std::vector<double> WithinNodes::ErrorsOfReadings(const std::vector<double>& output) const {
  struct Scatter {
    double square = 0.0, by_walk = 0.0, freedom = 0.0, span_s = 0.0;
  };
  const std::size_t runs = problem_->histories().size();
  std::vector<double> scatter_deg(runs, 0.0), out(runs, 0.0);
  for (int round = 0; round < 2; ++round) {
    std::vector<Scatter> scatter(runs);
    for (const MovingNode& node : nodes_) {
      const std::size_t run = problem_->row_refs()[static_cast<std::size_t>(node.row)].history;
      const Eigen::Map<const Eigen::VectorXd> own(output.data() + node.begin, node.count);
      if (round > 0 && own.cwiseAbs().maxCoeff() > kWild * scatter_deg[run]) continue;
      const auto first = static_cast<std::size_t>(node.begin);
      const double span_s =
          after_s_[first + static_cast<std::size_t>(node.count) - 1] - after_s_[first];
      const auto n = static_cast<double>(node.count);
      scatter[run].square += own.squaredNorm();
      // Sum over all pairs of their distance, of even ones, over n.
      scatter[run].by_walk += std::pow(walk_deg_sqrt_s_, 2) * span_s * (n + 1.0) / 6.0;
      scatter[run].freedom += n - 1.0;
      scatter[run].span_s = std::max(scatter[run].span_s, span_s);
    }
    for (std::size_t run = 0; run < runs; ++run) {
      const Scatter& own = scatter[run];
      scatter_deg[run] = own.freedom > 0.0 ? std::sqrt(own.square / own.freedom) : 0.0;
      const double square =
          own.freedom >= kLeastFreedom ? (own.square - own.by_walk) / own.freedom : 0.0;
      const bool by_errors = square > std::pow(walk_deg_sqrt_s_, 2) * own.span_s;
      out[run] = by_errors ? std::sqrt(square) : 0.0;
    }
  }
  for (std::size_t run = 0; run < runs; ++run) {
    for (const std::size_t axis : problem_->table_axes()) {
      const double step_deg = problem_->histories()[run].recording->reference_step_deg[axis];
      if (std::isfinite(step_deg) && out[run] < kDithered * step_deg) out[run] = 0.0;
    }
  }
  return out;
}

// Of errors and the walk within one node, of readings that come evenly; what is the same for all of
// them is taken off.
std::size_t WithinNodes::WhiteningOf(Eigen::Index readings, double step_s, double sigma_deg) {
  constexpr double kSame_s = 1e-4;
  const auto [place, is_new] = known_whitening_.try_emplace(
      {readings, std::lround(step_s / kSame_s), sigma_deg}, whitening_.size());
  if (!is_new) return place->second;
  const double walk = std::pow(walk_deg_sqrt_s_, 2) * step_s;
  const Eigen::MatrixXd covariance =
      Eigen::MatrixXd::NullaryExpr(readings, readings, [&](Eigen::Index i, Eigen::Index j) {
        return (i == j ? sigma_deg * sigma_deg : 0.0) + walk * static_cast<double>(std::min(i, j));
      });
  const Eigen::MatrixXd white =
      covariance.llt().matrixL().solve(Eigen::MatrixXd::Identity(readings, readings));
  const Eigen::VectorXd all = white.rowwise().sum().normalized();
  whitening_.push_back(white - all * (all.transpose() * white));
  return place->second;
}

// Of the axis of the table, at the reading, beyond the angle at the node.
double WithinNodes::OffMean_deg(const MovingNode& node, std::size_t axis,
                                Eigen::Index reading) const {
  const SensorState& point = StateAt(node);
  const auto& known = point.readings_off_mean_deg[axis];
  if (static_cast<Eigen::Index>(known.size()) == node.count)
    return known[static_cast<std::size_t>(reading)];
  return point.table_rate_deg_s[axis] * after_s_[static_cast<std::size_t>(node.begin + reading)];
}

// A step elsewhere changes nothing within the node.
bool WithinNodes::Contains(const MovingNode& node, double t_s) const {
  const double after_s = t_s - StateAt(node).t_s;
  const auto begin = static_cast<std::size_t>(node.begin);
  return after_s >= after_s_[begin] &&
         after_s <= after_s_[begin + static_cast<std::size_t>(node.count) - 1];
}

Eigen::MatrixXd WithinNodes::Columns(const Effect& effect, const BasisContext& context,
                                     std::optional<std::size_t> power_on) const {
  const std::unique_ptr<Basis> basis = effect.basis(context);
  const auto terms = static_cast<Eigen::Index>(effect.terms.size());
  Eigen::MatrixXd out = Eigen::MatrixXd::Zero(output_.size(), terms);
  Eigen::MatrixXd values(0, terms);
  std::vector<double> at(effect.terms.size());
  for (const MovingNode& node : nodes_) {
    const double felt = problem_->AxisProjection(node.row, context.table_axis);
    if (effect.search == Search::kTime && !Contains(node, context.nonlinear[0])) continue;
    if (felt == 0.0 || (power_on && problem_->power_on(node.row) != *power_on)) continue;
    SensorState point = StateAt(node);
    const double t_s = point.t_s, angle_deg = point.table_deg[context.table_axis];
    point.readings = 1;
    point.reading_step_s = 0.0;
    point.readings_off_mean_deg = {};
    values.resize(node.count, terms);
    for (Eigen::Index r = 0; r < node.count; ++r) {
      point.t_s = t_s + after_s_[static_cast<std::size_t>(node.begin + r)];
      point.table_deg[context.table_axis] = angle_deg + OffMean_deg(node, context.table_axis, r);
      basis->At(point, at.data());
      for (Eigen::Index j = 0; j < terms; ++j) values(r, j) = at[static_cast<std::size_t>(j)];
    }
    out.middleRows(node.begin, node.count) = felt * (White(node) * values);
  }
  return out;
}

void WithinNodes::ForEachReading(
    std::size_t axis, const Eigen::VectorXd& residual,
    const std::function<void(double angle_turns, double score)>& visit) const {
  Eigen::VectorXd score;
  for (const MovingNode& node : nodes_) {
    const double felt = problem_->AxisProjection(node.row, axis);
    const double angle_deg = StateAt(node).table_deg[axis];
    if (felt == 0.0 || !std::isfinite(angle_deg)) continue;
    score = White(node).transpose() * residual.segment(node.begin, node.count);
    for (Eigen::Index r = 0; r < node.count; ++r)
      visit((angle_deg + OffMean_deg(node, axis, r)) / kFullTurn_deg, felt * score(r));
  }
}

// Readings that follow each other by even steps of the angle have a mean of waves that is
// MeanOfWave; nodes with nearly the same step count together. Without the gyro's walk.
const std::vector<double>& WithinNodes::SquaresOfWaves(std::size_t axis,
                                                       std::size_t most_periods) const {
  constexpr double kSame_deg = 0.02;
  std::vector<double>& out = squares_[axis];
  if (out.size() == most_periods) return out;
  std::map<std::pair<Eigen::Index, long>, double> alike;
  for (const MovingNode& node : nodes_) {
    const double felt = problem_->AxisProjection(node.row, axis);
    const double step_deg = (OffMean_deg(node, axis, node.count - 1) - OffMean_deg(node, axis, 0)) /
                            static_cast<double>(node.count - 1);
    if (felt == 0.0 || !std::isfinite(step_deg)) continue;
    alike[{node.count, std::lround(std::fabs(step_deg) / kSame_deg)}] +=
        felt * felt * White(node).squaredNorm() * static_cast<double>(node.count) /
        static_cast<double>(node.count - 1);
  }
  out.assign(most_periods, 0.0);
  for (const auto& [node, square] : alike) {
    const double step_rad = static_cast<double>(node.second) * kSame_deg * kRadPerDeg;
    for (std::size_t k = 0; k < most_periods; ++k) {
      const double mean =
          MeanOfWave(static_cast<std::size_t>(node.first), static_cast<double>(k) * step_rad);
      out[k] += square * (1.0 - mean * mean);
    }
  }
  return out;
}

}  // namespace gyrobench::calibration
