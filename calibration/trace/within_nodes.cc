#include "calibration/trace/within_nodes.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <map>
#include <memory>
#include <utility>

#include "calibration/effects/basis.h"

namespace gyrobench::calibration {
namespace {

constexpr std::uint32_t kLeastReadings = 3;
constexpr double kLeastKnown = 100.0;  // second differences, for a standard deviation to be known
// In standard deviations: a node with such a second difference has a wild reading.
constexpr double kWild = 6.0;
// Of the variance of the walk over a node. Beside a larger walk the readings of a node are no
// longer independent of the rows of the nodes about it.
constexpr double kLeastOfWalk = 1.0;
// Noise of 0.4 of an encoder's step, of which rounding leaves a wave of 1.4 % of the step, scatters
// by sqrt(0.4^2 + 1/12) of it: the errors of less noise go by the angle.
constexpr double kDithered = 0.49;

bool IsWild(const double* off_deg, Eigen::Index count, double sigma_deg) {
  const double most_deg = kWild * std::sqrt(6.0) * sigma_deg;
  for (Eigen::Index r = 1; r + 1 < count; ++r) {
    if (std::fabs(off_deg[r - 1] - 2.0 * off_deg[r] + off_deg[r + 1]) > most_deg) return true;
  }
  return false;
}

// What the baseline has of a row beside its turns [deg].
double BesideTurns(const Baseline& baseline, const Eigen::VectorXd& fit, Eigen::Index row) {
  const auto turned = static_cast<Eigen::Index>(baseline.turned.size());
  const Eigen::Index rest = baseline.columns.cols() - turned;
  return baseline.columns.row(row).tail(rest).dot(fit.tail(rest));
}

// Rows of one motion, of which this one follows the one before.
bool Follows(const ChannelProblem& problem, Eigen::Index row) {
  if (row == 0) return false;
  const auto i = static_cast<std::size_t>(row);
  const std::vector<ProblemRow>& rows = problem.row_refs();
  return rows[i].history == rows[i - 1].history && rows[i].interval == rows[i - 1].interval + 1 &&
         !problem.intervals()[i - 1].still && !problem.intervals()[i].still;
}

// Where the speed changes within a node a delay, a filter and a scale factor that goes by the rate
// change within it as well, and would pass for what they are not.
bool IsSteady(const ChannelProblem& problem, Eigen::Index row) {
  constexpr double kShare = 0.005, kNoise_deg_s = 0.2;
  const auto rates = [&](Eigen::Index i) -> const Vector3& {
    return problem.half(i, 1).table_rate_deg_s;
  };
  const auto same = [&](Eigen::Index a, Eigen::Index b) {
    return std::ranges::all_of(problem.table_axes(), [&](std::size_t axis) {
      const double most = kShare * std::fabs(rates(a)[axis]) + kNoise_deg_s;
      return std::fabs(rates(a)[axis] - rates(b)[axis]) < most;
    });
  };
  return Follows(problem, row) && row + 1 < problem.rows() && Follows(problem, row + 1) &&
         same(row, row - 1) && same(row, row + 1);
}

// Of each row the rate that the baseline leaves of the rows about it [deg/s]: what is slow against
// the nodes, as the Earth's rotation, an eccentricity or a scale factor of the rate, goes evenly
// within a node. Of steady rows that follow each other.
std::vector<double> SlowRates(const ChannelProblem& problem, const std::vector<bool>& steady,
                              const Eigen::VectorXd& left_deg) {
  constexpr Eigen::Index kAbout = 5;  // on either side
  const auto goes_on = [&](Eigen::Index to, Eigen::Index row) {
    return Follows(problem, to) && steady[static_cast<std::size_t>(row)];
  };
  std::vector<double> out(steady.size(), 0.0);
  for (Eigen::Index i = 0; i < problem.rows(); ++i) {
    Eigen::Index begin = i, end = i + 1;
    while (begin > 0 && i - begin < kAbout && goes_on(begin, begin - 1)) --begin;
    while (end < problem.rows() && end - i <= kAbout && goes_on(end, end)) ++end;
    double duration_s = 0.0;
    for (Eigen::Index k = begin; k < end; ++k)
      duration_s += problem.intervals()[static_cast<std::size_t>(k)].duration_s;
    out[static_cast<std::size_t>(i)] = left_deg.segment(begin, end - begin).sum() / duration_s;
  }
  return out;
}

}  // namespace

WithinNodes::WithinNodes(const ChannelProblem& problem, const Baseline& baseline,
                         const Eigen::VectorXd& fit, double walk_deg_sqrt_s)
    : problem_(&problem), walk_deg_sqrt_s_(walk_deg_sqrt_s) {
  if (problem.table_axes().empty()) return;
  std::vector<double> output;
  Collect(baseline, fit, &output);
  std::map<Alike, double> sigma_deg = ErrorsOfReadings(output);
  // Rows of what is left, in order.
  std::vector<double> after_s;
  std::vector<double> kept;
  std::vector<MovingNode> nodes;
  for (MovingNode node : nodes_) {
    const double sigma = sigma_deg[AlikeOf(node)];
    const double* own = output.data() + node.begin;
    if (!(sigma > 0.0) || IsWild(own, node.count, sigma)) continue;
    const double step_s = SpanOf(node) / static_cast<double>(node.count - 1);
    const auto begin = static_cast<Eigen::Index>(kept.size());
    kept.insert(kept.end(), own, own + node.count);
    after_s.insert(after_s.end(), after_s_.begin() + node.begin,
                   after_s_.begin() + node.begin + node.count);
    node.begin = begin;
    node.white = WhiteningOf(node.count, step_s, sigma);
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
  // Of the output, whose readings are as they were stamped; those within a node are corrected.
  const double clocks = 1.0 - 1e-6 * problem_->corrected_drift_ppm();
  for (std::size_t j = 0; j < baseline.turned.size(); ++j)
    m[baseline.turned[j]] = fit(static_cast<Eigen::Index>(j)) / clocks;
  const double units = problem_->units_per_deg_s();
  for (Eigen::Index i = 0; i < problem_->rows(); ++i) steady_.push_back(IsSteady(*problem_, i));
  const std::vector<double> slow_deg_s =
      SlowRates(*problem_, steady_, problem_->output_deg() - baseline.columns * fit);
  for (Eigen::Index i = 0; i < problem_->rows(); ++i) {
    const StateHistory& history = problem_->history(i);
    const Interval& interval = problem_->intervals()[static_cast<std::size_t>(i)];
    const Node& epoch = problem_->end_epoch(i);
    if (interval.still || !problem_->FeelsTable(i) || epoch.within_count < kLeastReadings ||
        epoch.at.t_s != epoch.mean.t_s || !steady_[static_cast<std::size_t>(i)])
      continue;
    const double offset_deg_s = BesideTurns(baseline, fit, i) / interval.duration_s +
                                slow_deg_s[static_cast<std::size_t>(i)];
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

// Readings that turn at about one speed, and are felt by about as much, in one measurement: their
// errors grow with the speed where times are off.
WithinNodes::Alike WithinNodes::AlikeOf(const MovingNode& node) const {
  double rate_deg_s = 0.0, felt = 0.0;
  for (const std::size_t axis : problem_->table_axes()) {
    rate_deg_s = std::max(rate_deg_s, std::fabs(StateAt(node).table_rate_deg_s[axis]));
    felt = std::max(felt, std::fabs(problem_->AxisProjection(node.row, axis)));
  }
  const auto octave = [](double value) { return std::ilogb(std::max(value, 1e-3)); };
  return {problem_->row_refs()[static_cast<std::size_t>(node.row)].history, octave(rate_deg_s),
          octave(felt)};
}

// By the second differences of readings that follow each other, in which the gyro's walk and what
// is slow against the readings are next to nothing: their variance is 6 sigma^2. Twice, the second
// time without wild ones.
std::map<WithinNodes::Alike, double> WithinNodes::ErrorsOfReadings(
    const std::vector<double>& output) const {
  struct Scatter {
    double square = 0.0, count = 0.0, span_s = 0.0;
  };
  std::map<Alike, double> sigma_deg;
  for (int round = 0; round < 2; ++round) {
    std::map<Alike, Scatter> scatter;
    for (const MovingNode& node : nodes_) {
      const Alike alike = AlikeOf(node);
      if (round > 0 && IsWild(output.data() + node.begin, node.count, sigma_deg[alike])) continue;
      Scatter& own = scatter[alike];
      const double* at = output.data() + node.begin;
      for (Eigen::Index r = 1; r + 1 < node.count; ++r)
        own.square += std::pow(at[r - 1] - 2.0 * at[r] + at[r + 1], 2) / 6.0;
      own.count += static_cast<double>(node.count - 2);
      own.span_s = std::max(own.span_s, SpanOf(node));
    }
    sigma_deg.clear();
    for (const auto& [alike, own] : scatter) {
      const double square = own.count >= kLeastKnown ? own.square / own.count : 0.0;
      const bool by_errors = square > kLeastOfWalk * std::pow(walk_deg_sqrt_s_, 2) * own.span_s;
      sigma_deg[alike] = by_errors && !GoesByTheAngle(std::get<0>(alike), std::sqrt(square))
                             ? std::sqrt(square)
                             : 0.0;
    }
  }
  return sigma_deg;
}

double WithinNodes::SpanOf(const MovingNode& node) const {
  const auto first = static_cast<std::size_t>(node.begin);
  return after_s_[first + static_cast<std::size_t>(node.count) - 1] - after_s_[first];
}

// Errors of so little noise beside the steps in which the readings come.
bool WithinNodes::GoesByTheAngle(std::size_t run, double sigma_deg) const {
  return std::ranges::any_of(problem_->table_axes(), [&](std::size_t axis) {
    const double step_deg = problem_->histories()[run].recording->reference_step_deg[axis];
    return std::isfinite(step_deg) && sigma_deg < kDithered * step_deg;
  });
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
  const double after_s = after_s_[static_cast<std::size_t>(node.begin + reading)];
  if (known.size() < 2 || !(point.reading_step_s > 0.0))
    return point.table_rate_deg_s[axis] * after_s;
  // Known at even times, and between them by straight lines.
  const double place = (after_s - point.reading_after_s(0)) / point.reading_step_s;
  const double below = std::clamp(std::floor(place), 0.0, static_cast<double>(known.size() - 2));
  const auto i = static_cast<std::size_t>(below);
  return known[i] + (place - below) * (known[i + 1] - known[i]);
}

// What the outputs have lost with their slow rates, columns that act on all rows lose as well.
Eigen::MatrixXd WithinNodes::SlowRatesOf(const Eigen::MatrixXd& columns) const {
  Eigen::MatrixXd out(columns.rows(), columns.cols());
  for (Eigen::Index j = 0; j < columns.cols(); ++j) {
    const std::vector<double> slow = SlowRates(*problem_, steady_, columns.col(j));
    out.col(j) = Eigen::Map<const Eigen::VectorXd>(slow.data(), columns.rows());
  }
  return out;
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
  const bool of_axis = (effect.needs & kNeedsTableAxis) != 0;
  const Eigen::MatrixXd slow_deg_s =
      of_axis ? Eigen::MatrixXd() : SlowRatesOf(problem_->Columns(effect, context, power_on));
  for (const MovingNode& node : nodes_) {
    const double felt = of_axis ? problem_->AxisProjection(node.row, context.table_axis) : 1.0;
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
      for (Eigen::Index j = 0; j < terms; ++j) {
        const double slow_deg_per_s = of_axis ? 0.0 : slow_deg_s(node.row, j);
        values(r, j) = at[static_cast<std::size_t>(j)] - slow_deg_per_s * (point.t_s - t_s);
      }
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
  constexpr double kSame_deg = 0.005;
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
