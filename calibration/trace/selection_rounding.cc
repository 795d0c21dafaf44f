// What the rounding of the gyro's output, and that of the reference's readings, may make.
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>
#include <utility>
#include <vector>

#include "base/geometry.h"
#include "calibration/effects/basis.h"
#include "calibration/gls/scaled_ldlt.h"
#include "calibration/trace/selection.h"

namespace gyrobench::calibration {
namespace {

// Half a step, which rounding never errs by more than, is so many times the first harmonic.
constexpr double kAllHarmonics = 1.6;
// Harmonics of the wave of rounding that are followed from reading to reading.
constexpr int kHarmonics = 5;
// Of -2 log L: beyond what chance makes of some of the rows.
constexpr double kClear = 20.0;

// What is left of a ripple of size 1 in the means of a node's readings: root mean square over the
// way that its axis turns. Of many periods between readings most may be gone, but at the ends of a
// motion nothing is.
double LeftInMeans(const ChannelProblem& problem, const Candidate& ripple) {
  const std::size_t axis = ripple.context.table_axis;
  double square = 0.0, way = 0.0;
  for (const StateHistory& history : problem.histories()) {
    for (const SensorState& node : history.nodes) {
      const double rate_deg_s = std::fabs(node.table_rate_deg_s[axis]);
      if (!(rate_deg_s > 0.0)) continue;
      const double left = MeanOfWave(
          node.readings, ripple.context.nonlinear[0] * kRadPerDeg * node.reading_step_deg[axis]);
      square += rate_deg_s * left * left;
      way += rate_deg_s;
    }
  }
  return way > 0.0 ? std::sqrt(square / way) : 1.0;
}

// An axis turns at an even speed, and surely so from the end of one row to that of another.
struct SteadyTurn {
  Eigen::Index first = 0, last = 0;
  double duration_s = 0.0;  // with the rows before and after these

  // From the first row's end to the last one's, either sign.
  double Rate_deg_s(const ChannelProblem& problem, std::size_t axis) const {
    const SensorState &from = problem.end_node(first), &to = problem.end_node(last);
    return (to.table_deg[axis] - from.table_deg[axis]) / (to.t_s - from.t_s);
  }
};

// Calls `visit` with each steady turn of many rows.
template <typename Visit>
void ForEachSteadyTurn(const ChannelProblem& problem, std::size_t axis, Visit visit) {
  constexpr double kSameSpeed = 0.2;
  constexpr Eigen::Index kPartOfRamp = 6, kLeastRows = 10;  // at either end one row in so many
  const auto rate_deg_s = [&](Eigen::Index row) {
    return problem.half(row, 1).table_rate_deg_s[axis];
  };
  const auto goes_on = [&](Eigen::Index row, double as_deg_s) {
    return row < problem.rows() && problem.intervals()[static_cast<std::size_t>(row)].GoesOn() &&
           std::fabs(rate_deg_s(row) - as_deg_s) < kSameSpeed * std::fabs(as_deg_s);
  };
  for (Eigen::Index begin = 0, end = 0; begin < problem.rows(); begin = end) {
    end = begin + 1;
    while (goes_on(end, rate_deg_s(begin))) ++end;
    const Eigen::Index ramp = (end - begin) / kPartOfRamp;
    const SteadyTurn turn{begin + ramp, end - 1 - ramp,
                          problem.end_s(end - 1) - problem.begin_s(begin)};
    if (turn.last - turn.first >= kLeastRows) visit(turn);
  }
}

double OffWhole(double value) { return std::fabs(std::remainder(value, 1.0)); }

// The most that rounding to steps of `step_deg` adds to a tone in one steady turn, as a part of the
// first harmonic of its wave. The k-th harmonic has 1/k of the first one's size and k times as many
// periods from node to node as these are steps apart; whole periods do not show. The means of the
// nodes' readings leave a part of it, and a part of the tone.
double PartOfWave(const ChannelProblem& problem, std::size_t axis, const SteadyTurn& turn,
                  double step_deg, double frequency_hz) {
  // A turn of T seconds tells frequencies by 1/T, and its speed by a part of a step in T seconds.
  constexpr double kPartOfStep = 0.3;
  const SensorState& from = problem.end_node(turn.first);
  const double duration_s = problem.end_node(turn.last).t_s - from.t_s;
  const auto middle = static_cast<std::size_t>((turn.first + turn.last) / 2);
  const double interval_s = problem.intervals()[middle].duration_s;
  const double steps_per_s = turn.Rate_deg_s(problem, axis) / step_deg;
  const auto left = [&](double hz) {
    return std::fabs(MeanOfWave(from.readings, kTwoPi * hz * from.reading_step_s));
  };
  double part = 0.0;
  for (int k = 1; k <= kHarmonics; ++k) {
    const double wave_hz = k * steps_per_s;
    const double off = std::min(OffWhole((wave_hz - frequency_hz) * interval_s),
                                OffWhole((wave_hz + frequency_hz) * interval_s));
    if (off < (1.0 + kPartOfStep * k) * interval_s / duration_s) part += left(wave_hz) / k;
  }
  return part > 0.0 ? std::min(1.0, part) / left(frequency_hz) : 0.0;
}

}  // namespace

// At even speed rounding makes tones of the angle, whose frequencies follow from the speed, and
// whose mean over all rows is no larger than what the turns add together. While the table rests it
// makes none.
bool Selection::MayBeToneOfReadings(const Candidate& tone, const Eigen::VectorXd& all,
                                    const WhiteStore::Columns& others) const {
  if (!(problem_->rounding_deg() > 0.0)) return false;
  const double frequency_hz = tone.context.nonlinear[0];
  // What has no column was taken off as it is.
  const double own = turns_itself_ ? std::fabs(all(0)) : 1.0;
  const double by_others = all.head(turned_).cwiseAbs().sum() - (turns_itself_ ? own : 0.0);
  double sum_deg_times_s = 0.0, time_s = 0.0;
  for (Eigen::Index i = 0; i < problem_->rows(); ++i) time_s += DurationOf(i);
  for (std::size_t axis = 0; axis < 3; ++axis) {
    ForEachSteadyTurn(*problem_, axis, [&](const SteadyTurn& turn) {
      const double step_deg = problem_->history(turn.first).rest_flicker[axis].step_deg;
      if (!(step_deg > 0.0) || !std::isfinite(step_deg)) return;
      const double felt = own * std::fabs(problem_->AxisProjection(turn.first, axis)) + by_others;
      sum_deg_times_s += felt * problem_->rounding_wave_deg(axis) *
                         PartOfWave(*problem_, axis, turn, step_deg, frequency_hz) *
                         turn.duration_s;
    });
  }
  const double amplitude_deg_s = all.tail(static_cast<Eigen::Index>(tone.columns.size())).norm();
  const double amplitude_deg = amplitude_deg_s / (kTwoPi * frequency_hz);
  return amplitude_deg < kAllHarmonics * sum_deg_times_s / time_s && !RestsShow(tone, others);
}

bool Selection::RestsShow(const Candidate& candidate, const WhiteStore::Columns& others) const {
  std::vector<Eigen::Index> rests;
  for (Eigen::Index i = 0; i < problem_->rows(); ++i) {
    if (problem_->intervals()[static_cast<std::size_t>(i)].still) rests.push_back(i);
  }
  return !rests.empty() && ByRows(rests, candidate, others).gain > kClear;
}

// Turns at an even speed at which rounding makes no wave of this period, and of which each period
// has two rows and more, show a larger one than errors by chance have it, as those of rounding are
// there. Turns at one speed may err alike, and count once.
bool Selection::TurnsShow(const Candidate& ripple, double scale,
                          const WhiteStore::Columns& others) const {
  constexpr double kOtherSpeed = 0.05, kBeyondChance = 5.0, kMostPeriods = 0.5;  // a row
  const std::size_t axis = ripple.context.table_axis;
  std::vector<Eigen::Index> rows;
  std::vector<std::pair<double, Eigen::Index>> longest;  // of each speed
  ForEachSteadyTurn(*problem_, axis, [&](const SteadyTurn& turn) {
    const double step_deg = problem_->history(turn.first).rest_flicker[axis].step_deg;
    const double speed_deg_s = std::fabs(turn.Rate_deg_s(*problem_, axis));
    const double frequency_hz = ripple.context.nonlinear[0] * speed_deg_s / kFullTurn_deg;
    if (!(frequency_hz * DurationOf(turn.first) < kMostPeriods) ||
        PartOfWave(*problem_, axis, turn, step_deg, frequency_hz) > 0.0)
      return;
    const Eigen::Index count = turn.last - turn.first + 1;
    for (Eigen::Index i = 0; i < count; ++i) rows.push_back(turn.first + i);
    const auto same = std::ranges::find_if(longest, [&](const auto& one) {
      return std::fabs(one.first - speed_deg_s) < kOtherSpeed * speed_deg_s;
    });
    if (same == longest.end()) {
      longest.emplace_back(speed_deg_s, count);
    } else {
      same->second = std::max(same->second, count);
    }
  });
  if (rows.empty()) return false;
  double apart = 0.0;
  for (const auto& [speed_deg_s, count] : longest) apart += static_cast<double>(count);
  const double error_deg = problem_->rounding_error_deg(axis);
  const ShownByRows shown = ByRows(rows, ripple, others);
  // Nor as large as the first of the harmonics that are not looked at in each turn.
  const double least_deg = std::max(kBeyondChance * error_deg * std::sqrt(2.0 / apart),
                                    problem_->rounding_wave_deg(axis) / (kHarmonics + 1));
  return shown.gain > kClear && shown.values.norm() > std::fabs(scale) * least_deg;
}

// What these rows alone ask for.
Selection::ShownByRows Selection::ByRows(const std::vector<Eigen::Index>& rows,
                                         const Candidate& candidate,
                                         const WhiteStore::Columns& others) const {
  const Projection others_off(store_.Take(others));
  const Eigen::MatrixXd own = others_off.Off(store_.Take(candidate.columns))(rows, Eigen::all);
  const Eigen::VectorXd residual = others_off.Off(store_.output());
  const Eigen::VectorXd right = own.transpose() * residual(rows);
  const ScaledLdlt products(own.transpose() * own);
  return {products.Square(right), products.Solve(right)};
}

// The error e of a reading is in the output and in the angle that a wave is a function of: the mean
// of e sin(k (phi + e)) is a wave of the size k e^2. The angle is known better than by one reading
// where the gyro carries it: so much it is at most. What rounding makes is a wave as well, of as
// many periods a turn as the encoder has steps; at even times it passes for one of fewer, and for a
// larger one where that would hardly be left in the means of readings.
bool Selection::MayBeOfReadings(const Candidate& ripple, double amplitude, double scale,
                                const WhiteStore::Columns& others) const {
  constexpr double kClearly = 3.0;
  const std::size_t axis = ripple.context.table_axis;
  const double amplitude_deg = amplitude / std::fabs(scale);
  const double error_deg = problem_->angle_error_deg(axis);
  const double of_error_deg =
      kClearly * ripple.context.nonlinear[0] * error_deg * error_deg * kRadPerDeg;
  const double of_rounding_deg = kAllHarmonics * problem_->rounding_wave_deg(axis);
  if (amplitude_deg < of_error_deg) return true;
  if (amplitude_deg < of_rounding_deg) return !TurnsShow(ripple, scale, others);
  // Single readings have rows only where noise hides the steps, and means leave nothing out.
  return of_rounding_deg > 0.0 && within_.empty() &&
         amplitude_deg * LeftInMeans(*problem_, ripple) < of_rounding_deg;
}

// What a candidate adds beside the others is nowhere larger than the wave which rounding makes of
// the rate, or, where it follows the rate, explains no more than such a wave would, with whatever
// signs suit the candidate best: at the few speeds and offsets of a table the wave passes for any
// of them.
bool Selection::MayBeRounding(const Candidate& candidate, const WhiteStore::Columns& others) const {
  const double wave_deg_s = problem_->output_rounding_deg_s();
  const bool of_angle =
      candidate.effect != nullptr && candidate.effect->domain == EffectDomain::kAngle;
  if (!(wave_deg_s > 0.0) || of_angle) return false;
  WhiteStore::Columns model = others;
  model.insert(model.end(), candidate.columns.begin(), candidate.columns.end());
  const Eigen::VectorXd values =
      store_.Solve(model).tail(static_cast<Eigen::Index>(candidate.columns.size()));
  const Eigen::VectorXd turned_deg =
      (candidate.raw ? candidate.raw->Copy() : ColumnsOf(*problem_, candidate, covariates())) *
      values;
  double largest_deg_s = 0.0;
  for (Eigen::Index i = 0; i < turned_deg.size(); ++i)
    largest_deg_s = std::max(largest_deg_s, std::fabs(turned_deg(i)) / DurationOf(i));
  if (largest_deg_s < wave_deg_s) return true;
  const bool of_rate = candidate.effect == nullptr || (candidate.effect->needs & kNeedsRate) != 0;
  return of_rate && Cost(others) - Cost(model) < GainOfWave(wave_deg_s, candidate, values, others);
}

// The most that a wave of the rate can make a candidate with these coefficients explain beside the
// others: a row that it moves by w is worth |r| w, where r is what the candidate does in that row
// and the others do not. The noise of the readings, which makes w smaller, is left aside.
double Selection::GainOfWave(double wave_deg_s, const Candidate& candidate,
                             const Eigen::VectorXd& values,
                             const WhiteStore::Columns& others) const {
  const Eigen::VectorXd own =
      Projection(store_.Take(others)).Off(store_.Take(candidate.columns) * values);
  double along = 0.0;
  for (Eigen::Index i = 0; i < own.size(); ++i)
    along += std::fabs(own(i)) * wave_deg_s * std::sqrt(DurationOf(i)) / walk_deg_sqrt_s_;
  const double square = own.squaredNorm();
  return square > 0.0 ? along * along / square : std::numeric_limits<double>::infinity();
}

double Selection::DurationOf(Eigen::Index row) const {
  return problem_->intervals()[static_cast<std::size_t>(row)].duration_s;
}

}  // namespace gyrobench::calibration
