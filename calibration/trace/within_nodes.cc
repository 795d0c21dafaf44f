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
constexpr Eigen::Index kLeastOfRun = 100;  // readings, of which a standard deviation is known
// In standard deviations: a node with such a reading has a wild one.
constexpr double kWild = 6.0;

// What the baseline has of a row beside its turns [deg].
double BesideTurns(const Baseline& baseline, const Eigen::VectorXd& fit, Eigen::Index row) {
  const auto turned = static_cast<Eigen::Index>(baseline.turned.size());
  const Eigen::Index rest = baseline.columns.cols() - turned;
  return baseline.columns.row(row).tail(rest).dot(fit.tail(rest));
}

}  // namespace

WithinNodes::WithinNodes(const ChannelProblem& problem, const Baseline& baseline,
                         const Eigen::VectorXd& fit)
    : problem_(&problem) {
  Collect(baseline, fit);
  Weigh();
}

void WithinNodes::Collect(const Baseline& baseline, const Eigen::VectorXd& fit) {
  Vector3 m = {};
  m[problem_->channel()] = 1.0;
  for (std::size_t j = 0; j < baseline.turned.size(); ++j)
    m[baseline.turned[j]] = fit(static_cast<Eigen::Index>(j));
  std::vector<double> output;
  const double units = problem_->units_per_deg_s();
  for (Eigen::Index i = 0; i < problem_->rows(); ++i) {
    const StateHistory& history = problem_->history(i);
    const Interval& interval = problem_->intervals()[static_cast<std::size_t>(i)];
    const Node& epoch = problem_->end_epoch(i);
    if (interval.still || !problem_->FeelsTable(i) || epoch.within_count < kLeastReadings ||
        history.rounding_deg > 0.0 || epoch.at.t_s != epoch.mean.t_s)
      continue;
    const double offset_deg_s = BesideTurns(baseline, fit, i) / interval.duration_s;
    const ReadingWithin* reading = history.recording->columns.within.data() + epoch.within_begin;
    nodes_.push_back({i, static_cast<Eigen::Index>(output.size()), epoch.within_count});
    for (std::uint32_t k = 0; k < epoch.within_count; ++k, ++reading) {
      const auto turned = [&](std::size_t c) {
        return static_cast<double>(reading->rotation_deg[c]);
      };
      const double after_s = static_cast<double>(reading->after_s);
      double off_deg =
          static_cast<double>(reading->z[problem_->channel()]) / units - offset_deg_s * after_s;
      for (std::size_t c = 0; c < 3; ++c) off_deg -= m[c] * turned(c);
      output.push_back(off_deg);
      after_s_.push_back(after_s);
      per_sigma_.push_back(std::sqrt(static_cast<double>(reading->readings)));
    }
  }
  output_ =
      Eigen::Map<const Eigen::VectorXd>(output.data(), static_cast<Eigen::Index>(output.size()));
}

// By the scatter of each measurement: twice, the second time without wild ones.
void WithinNodes::Weigh() {
  const auto history_of = [&](const MovingNode& node) { return &problem_->history(node.row); };
  std::map<const StateHistory*, double> sigma_deg;
  for (int round = 0; round < 2; ++round) {
    struct Scatter {
      double square = 0.0, freedom = 0.0;
      Eigen::Index readings = 0;
    };
    std::map<const StateHistory*, Scatter> scatter;
    for (const MovingNode& node : nodes_) {
      double square = 0.0, largest = 0.0;
      for (Eigen::Index r = node.begin; r < node.begin + node.count; ++r) {
        const double own = std::pow(output_(r) * per_sigma_[static_cast<std::size_t>(r)], 2);
        square += own;
        largest = std::max(largest, own);
      }
      const auto known = sigma_deg.find(history_of(node));
      if (known != sigma_deg.end() && largest > std::pow(kWild * known->second, 2)) continue;
      Scatter& of_run = scatter[history_of(node)];
      of_run.square += square;
      of_run.freedom += static_cast<double>(node.count - 1);
      of_run.readings += node.count;
    }
    sigma_deg.clear();
    for (const auto& [history, of_run] : scatter) {
      if (of_run.readings >= kLeastOfRun && of_run.square > 0.0)
        sigma_deg[history] = std::sqrt(of_run.square / of_run.freedom);
    }
  }
  for (const MovingNode& node : nodes_) {
    const auto known = sigma_deg.find(history_of(node));
    double weight = known == sigma_deg.end() ? 0.0 : 1.0 / known->second;
    for (Eigen::Index r = node.begin; r < node.begin + node.count; ++r) {
      const double own = output_(r) * per_sigma_[static_cast<std::size_t>(r)];
      if (weight > 0.0 && std::fabs(own) > kWild * known->second) weight = 0.0;
    }
    for (Eigen::Index r = node.begin; r < node.begin + node.count; ++r) {
      double& per_sigma = per_sigma_[static_cast<std::size_t>(r)];
      per_sigma *= weight;
      output_(r) *= per_sigma;
    }
  }
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
    const Eigen::Map<const Eigen::VectorXd> per_sigma(per_sigma_.data() + node.begin, node.count);
    const Eigen::VectorXd weights = per_sigma;
    const double all = weights.squaredNorm();
    if (!(all > 0.0)) continue;
    for (Eigen::Index j = 0; j < terms; ++j) {
      const double mean = weights.cwiseAbs2().dot(values.col(j)) / all;
      out.col(j).segment(node.begin, node.count) =
          felt * weights.array() * (values.col(j).array() - mean);
    }
  }
  return out;
}

void WithinNodes::ForEachReading(
    std::size_t axis, const std::function<void(Eigen::Index, double, double)>& visit) const {
  for (const MovingNode& node : nodes_) {
    const double felt = problem_->AxisProjection(node.row, axis);
    const double angle_deg = StateAt(node).table_deg[axis];
    if (felt == 0.0 || !std::isfinite(angle_deg)) continue;
    for (Eigen::Index r = 0; r < node.count; ++r) {
      visit(node.begin + r, (angle_deg + OffMean_deg(node, axis, r)) / kFullTurn_deg,
            felt * per_sigma_[static_cast<std::size_t>(node.begin + r)]);
    }
  }
}

// Readings that follow each other by even steps of the angle have a mean of waves that is
// MeanOfWave; nodes with nearly the same step count together.
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
    double square = 0.0;
    for (Eigen::Index r = node.begin; r < node.begin + node.count; ++r)
      square += std::pow(felt * per_sigma_[static_cast<std::size_t>(r)], 2);
    alike[{node.count, std::lround(std::fabs(step_deg) / kSame_deg)}] += square;
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
