// Angles of the table at the nodes without the noise of their own reading.
#include <cmath>
#include <optional>
#include <vector>

#include "calibration/state/history_parts.h"
#include "calibration/state/timing_error.h"

namespace gyrobench::calibration {
namespace {

class AngleSmoother {
 public:
  explicit AngleSmoother(StateHistory* history) : history_(*history), nodes_(history->epochs) {}

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
    for (std::size_t k = 0; k < nodes_.size(); ++k) history_.nodes[k].table_deg[axis] = angles[k];
  }

 private:
  // What the gyro saw since the readings on either side of a node, and how many these are.
  struct Carried {
    double angle_deg = 0.0, neighbours = 0.0;
  };

  // In a term that depends on the angle the noise of its own reading would be found again, as a
  // ripple. No neighbours where the carried angle is not known.
  std::vector<Carried> CarriedAngles(std::size_t axis) const {
    constexpr std::size_t kPairs = 3;
    auto off = [&](std::size_t j) {
      const SensorState& point = history_.nodes[j];
      return point.table_deg[axis] - point.table_by_gyro_deg[axis];
    };
    std::vector<Carried> out(nodes_.size());
    for (std::size_t k = 0; k < nodes_.size(); ++k) {
      double sum = 0.0, count = 0.0;
      for (std::size_t d = 1; d <= kPairs && d <= k && k + d < nodes_.size(); ++d) {
        if (!TurnsUpTo(history_, k + 1 - d, axis) || !TurnsUpTo(history_, k + d, axis)) break;
        sum += off(k - d) + off(k + d);
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
    constexpr double kSteady = 0.1;
    std::vector<SteadyAngle> out;
    for (std::size_t k = 1; k + 1 < nodes_.size(); ++k) {
      const double residual_deg = history_.nodes[k].table_deg[axis] - carried[k].angle_deg;
      if (!(carried[k].neighbours > 0.0) || !std::isfinite(residual_deg)) continue;
      const double before = RateByGyro(k, axis), after = RateByGyro(k + 1, axis);
      if (!(std::fabs(after - before) < kSteady * std::fabs(after))) continue;
      out.push_back({.residual_deg = residual_deg,
                     .rate_deg_s = 0.5 * (before + after),
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
};

}  // namespace

double ReadingsBehind(const Node& node, std::size_t axis) {
  if (!node.mean.output_known) return 1.0;
  const double own = node.mean.own_readings[axis];
  return std::fmax(1.0, own > 0.0 ? own : node.mean.readings);
}

void SmoothAngles(StateHistory* history) {
  AngleSmoother smoother(history);
  for (std::size_t axis = 0; axis < 3; ++axis) smoother.Smooth(axis);
}

}  // namespace gyrobench::calibration
