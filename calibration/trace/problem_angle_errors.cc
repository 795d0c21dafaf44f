// What a problem's baseline has of the reference's angle errors: in the turns about other axes, and
// in the time at which the shape of the filter is felt.
#include <algorithm>
#include <cmath>

#include "calibration/trace/problem.h"

namespace gyrobench::calibration {

bool GyroDelayIsDeclared(std::span<const StateHistory> histories) {
  return std::ranges::any_of(histories, [](const StateHistory& history) {
    return history.recording->info.gyro_delay_s > 0.0;
  });
}

bool ChannelProblem::DelayIsDeclared() const {
  return (observables() & kNeedsRate) != 0 && GyroDelayIsDeclared(histories_);
}

Eigen::VectorXd ChannelProblem::Turn(std::size_t axis) const {
  Eigen::VectorXd turn_deg = TurnByRates(axis);
  if (axis == channel_ || angle_errors_[axis] == nullptr) return turn_deg;
  for (Eigen::Index i = 0; i < rows(); ++i)
    turn_deg(i) += angle_errors_[axis]->turn_beyond_deg[ref(i).history][ref(i).interval];
  return turn_deg;
}

// Change of the angular acceleration that the gyro shows over each row in motion [deg/s^2], at the
// time at which the reference has it.
Eigen::VectorXd ChannelProblem::FilterShape() const {
  Eigen::VectorXd out = Eigen::VectorXd::Zero(rows());
  const ReferenceAngleError* error = angle_errors_[channel_].get();
  for (Eigen::Index i = 0; i < rows(); ++i) {
    const StateHistory& measured = history(i);
    if (!(measured.recording->info.gyro_delay_s > 0.0) ||
        intervals_[static_cast<std::size_t>(i)].still)
      continue;
    const auto at = [&](std::size_t node) {
      const SensorState& point = measured.nodes[node];
      const double after_s = error == nullptr ? 0.0 : TotalDelay_s(error->delays, point.t_s);
      const double shown = AccelerationAfter_deg_s2(point, channel_, after_s);
      return std::isfinite(shown) ? shown : 0.0;
    };
    const std::size_t interval = ref(i).interval;
    out(i) = at(interval + 1) - at(interval);
  }
  return out;
}

}  // namespace gyrobench::calibration
