// Angles of the table at the nodes without the noise of their own reading, and with so much of it
// that their errors are none of what is left of the gyro's output.
#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>
#include <vector>

#include "calibration/state/even_turns.h"
#include "calibration/state/history_parts.h"
#include "calibration/state/timing_error.h"

namespace gyrobench::calibration {
namespace {

class AngleSmoother {
 public:
  AngleSmoother(const Vector3& walk_deg_sqrt_s, StateHistory* history)
      : history_(*history), nodes_(history->epochs), walk_deg_sqrt_s_(walk_deg_sqrt_s) {
    for (const double walk : walk_deg_sqrt_s)
      largest_walk_deg_sqrt_s_ = std::fmax(largest_walk_deg_sqrt_s_, walk);
  }

  // Only where the gyro follows the table better than this: of a table that vibrates the gyro's
  // samples tell no more than one reading does.
  void Smooth(std::size_t axis) {
    constexpr double kFollows_deg = 0.2;
    const std::vector<Carried> carried = CarriedAngles(axis);
    const std::optional<AngleErrors> errors =
        FindAngleErrors(SteadyAngles(axis, carried), history_.recording->reference_step_deg[axis]);
    if (errors) {
      const double timing_s = std::sqrt(errors->timing_s2);
      history_.timing_error_s = std::fmax(history_.timing_error_s, timing_s);
      history_.timing_at_most_s =
          std::fmin(history_.timing_at_most_s, std::sqrt(errors->timing_at_most_s2));
    }
    std::vector<double> angles(nodes_.size());
    double square = 0.0, count = 0.0;
    for (std::size_t k = 0; k < nodes_.size(); ++k) {
      const double own_deg = history_.nodes[k].table_deg[axis];
      angles[k] = carried[k].neighbours > 0.0 ? carried[k].angle_deg : own_deg;
      if (!(std::fabs(own_deg - angles[k]) > 0.0)) continue;
      if (errors) {
        const double share = errors->TimingShare(history_.nodes[k].table_rate_deg_s[axis],
                                                 ReadingsBehind(nodes_[k], axis));
        angles[k] += share * (own_deg - angles[k]);
      }
      square += std::pow(own_deg - angles[k], 2);
      count += 1.0;
    }
    if (count == 0.0 || std::sqrt(square / count) > kFollows_deg) return;
    const double own_share = OwnShare(axis);
    const std::vector<std::optional<double>> of_even_turns = EvenTurns(axis);
    for (std::size_t k = 0; k < nodes_.size(); ++k) {
      SensorState& point = history_.nodes[k];
      if (of_even_turns[k]) {
        point.table_deg[axis] = *of_even_turns[k];
        continue;
      }
      const double off_deg = std::exchange(point.table_deg[axis], angles[k]) - angles[k];
      const bool steady = k > 0 && k + 1 < nodes_.size() && IsSteady(k, axis);
      if (!steady || !std::isfinite(off_deg)) continue;
      point.own_part_deg[axis] = own_share * off_deg;
      point.steady_step_deg[axis] = SteadyStep_deg(k, axis);
    }
  }

 private:
  // What the gyro saw since the readings on either side of a node, and how many these are.
  struct Carried {
    double angle_deg = 0.0, neighbours = 0.0;
  };

  // What a reading is off the gyro.
  double Off(std::size_t k, std::size_t axis) const {
    return history_.nodes[k].table_deg[axis] - history_.nodes[k].table_by_gyro_deg[axis];
  }

  // Of a node's own reading in its angle, beside the readings about it that the gyro carried there,
  // for waves of few periods a turn in steady turns, in which the scale factor goes by the
  // neighbours' rates. Of a ripple the reading itself has what it misreads.
  //
  // The residual of an interval is e = D(x - d): d the error of a node's readings, of variance s^2,
  // x the gyro's angle random walk, which grows by N^2 T from node to node, D the difference of
  // neighbours. An angle in which the own reading has the share w errs by x_k less a mean of x - d
  // about it. Generalised least squares, V = cov(e), finds tr(V^-1 cov(D x)) - w a node of it in e,
  // and takes that for a term that depends on the angle: for one of long waves with a smaller w, as
  // what the gyro measures is in its angle then, with a larger one for the reading's noise. A node
  // that is the mean of readings shares the part a / 2 of N^2 T with each neighbour, so that at the
  // wave number u, with c = 1 - cos u,
  //   cov(D x) = N^2 T (1 - a c),   V = cov(D x) + 2 s^2 c,
  // and the mean over u of their ratio is
  //   w = (1 - 2 a / (1 + r)) / r,   r^2 = 1 - 2 a + 4 s^2 / (N^2 T).
  // Both noises are those of rests: what moves with the table, as a wave of the angle, is none.
  double OwnShare(std::size_t axis) const {
    double shared_s = 0.0, length_s = 0.0, walk_deg2 = 0.0, steady = 0.0;
    for (std::size_t k = 1; k + 1 < nodes_.size(); ++k) {
      if (!IsSteady(k, axis)) continue;
      const double step_s = nodes_[k].at.t_s - nodes_[k - 1].at.t_s;
      const Matrix3 rates = history_.stand.Rates(history_.nodes[k].table_deg);
      for (std::size_t c = 0; c < 3; ++c)
        walk_deg2 += std::pow(rates[c][axis] * walk_deg_sqrt_s_[c], 2) * step_s;
      shared_s += 2.0 * history_.reference_walk_s[k];
      length_s += step_s;
      steady += 1.0;
    }
    const double reading_deg2 = std::pow(history_.axis_error_deg[axis], 2);
    if (!(walk_deg2 > 0.0) || !(reading_deg2 > 0.0)) return 0.0;
    const double a = std::clamp(shared_s / length_s, 0.0, 0.5);
    const double r = std::sqrt(1.0 - 2.0 * a + 4.0 * reading_deg2 * steady / walk_deg2);
    return std::clamp((1.0 - 2.0 * a / (1.0 + r)) / r, 0.0, 1.0);
  }

  // The table turns, and the gyro neither speeds up nor slows down by more than its noise.
  bool IsSteady(std::size_t k, std::size_t axis) const {
    constexpr double kSteady = 0.1;
    if (!TurnsUpTo(history_, k, axis) || !TurnsUpTo(history_, k + 1, axis)) return false;
    const double before = RateByGyro(k, axis), after = RateByGyro(k + 1, axis);
    const double length_s = nodes_[k].at.t_s - nodes_[k - 1].at.t_s;
    const double noise = kNoiseSigmas * largest_walk_deg_sqrt_s_ * std::sqrt(2.0 / length_s);
    return before * after > 0.0 &&
           std::fabs(after - before) < std::max(kSteady * std::fabs(after), noise);
  }

  // From node to node, over so many steady ones on either side that the gyro's noise makes little.
  double SteadyStep_deg(std::size_t k, std::size_t axis) const {
    constexpr std::size_t kReach = 8;
    std::size_t from = k - 1, to = k + 1;
    while (from > 0 && k - from < kReach && IsSteady(from, axis)) --from;
    while (to + 1 < nodes_.size() && to - k < kReach && IsSteady(to, axis)) ++to;
    return (history_.nodes[to].table_by_gyro_deg[axis] -
            history_.nodes[from].table_by_gyro_deg[axis]) /
           static_cast<double>(to - from);
  }

  // Of the nodes in slow and even turns the angle by a line through many.
  std::vector<std::optional<double>> EvenTurns(std::size_t axis) const {
    std::vector<double> t_s, read_deg, felt_deg;
    for (std::size_t k = 0; k < nodes_.size(); ++k) {
      t_s.push_back(nodes_[k].at.t_s);
      read_deg.push_back(history_.nodes[k].table_deg[axis]);
      felt_deg.push_back(history_.nodes[k].table_by_gyro_deg[axis]);
    }
    const AngleSeries series = {t_s, read_deg, felt_deg, history_.axis_error_deg[axis],
                                largest_walk_deg_sqrt_s_};
    std::vector<std::optional<double>> out(nodes_.size());
    std::size_t end = 0;
    for (std::size_t begin = 0; begin < nodes_.size(); begin = end) {
      for (end = begin + 1; end < nodes_.size() && TurnsUpTo(history_, end, axis);) ++end;
      for (std::size_t k = begin; k < end; ++k) {
        if (const auto turn = FindEvenTurn(series, k, t_s[k], begin, end)) out[k] = turn->angle_deg;
      }
    }
    return out;
  }

  // In a term that depends on the angle the noise of its own reading would be found again, as a
  // ripple. No neighbours where the carried angle is not known.
  std::vector<Carried> CarriedAngles(std::size_t axis) const {
    constexpr std::size_t kPairs = 3;
    std::vector<Carried> out(nodes_.size());
    for (std::size_t k = 0; k < nodes_.size(); ++k) {
      double sum = 0.0, count = 0.0;
      for (std::size_t d = 1; d <= kPairs && d <= k && k + d < nodes_.size(); ++d) {
        if (!TurnsUpTo(history_, k + 1 - d, axis) || !TurnsUpTo(history_, k + d, axis)) break;
        sum += Off(k - d, axis) + Off(k + d, axis);
        count += 2.0;
      }
      const double angle_deg = history_.nodes[k].table_by_gyro_deg[axis] + sum / count;
      if (std::isfinite(angle_deg)) out[k] = {angle_deg, count};
    }
    return out;
  }

  // Of nodes at which the gyro neither speeds up nor slows down.
  std::vector<SteadyAngle> SteadyAngles(std::size_t axis,
                                        const std::vector<Carried>& carried) const {
    std::vector<SteadyAngle> out;
    for (std::size_t k = 1; k + 1 < nodes_.size(); ++k) {
      const double residual_deg = history_.nodes[k].table_deg[axis] - carried[k].angle_deg;
      if (!(carried[k].neighbours > 0.0) || !std::isfinite(residual_deg)) continue;
      if (!IsSteady(k, axis)) continue;
      out.push_back({.residual_deg = residual_deg,
                     .rate_deg_s = 0.5 * (RateByGyro(k, axis) + RateByGyro(k + 1, axis)),
                     .angle_deg = carried[k].angle_deg,
                     .readings = ReadingsBehind(nodes_[k], axis),
                     .neighbours = carried[k].neighbours,
                     .place = k});
    }
    return out;
  }

  double RateByGyro(std::size_t k, std::size_t axis) const {
    return (history_.nodes[k].table_by_gyro_deg[axis] -
            history_.nodes[k - 1].table_by_gyro_deg[axis]) /
           (nodes_[k].at.t_s - nodes_[k - 1].at.t_s);
  }

  StateHistory& history_;
  const std::vector<Node>& nodes_;
  Vector3 walk_deg_sqrt_s_;
  double largest_walk_deg_sqrt_s_ = 0.0;
};

}  // namespace

double ReadingsBehind(const Node& node, std::size_t axis) {
  if (!node.mean.output_known) return 1.0;
  const double own = node.mean.own_readings[axis];
  return std::fmax(1.0, own > 0.0 ? own : node.mean.readings);
}

void SmoothAngles(const Vector3& walk_deg_sqrt_s, StateHistory* history) {
  AngleSmoother smoother(walk_deg_sqrt_s, history);
  for (std::size_t axis = 0; axis < 3; ++axis) smoother.Smooth(axis);
}

}  // namespace gyrobench::calibration
