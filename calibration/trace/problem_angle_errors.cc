// What a problem has of the reference's angle errors that channels found: in the turns about other
// axes, in the direction that motions come from, and in the time at which the shape of the filter
// is felt.
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <Eigen/Eigenvalues>
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

double ChannelProblem::corrected_drift_ppm() const {
  return (observables() & kNeedsRate) != 0
             ? histories_.front().recording->drift_correction.drift_ppm
             : 0.0;
}

// From the stamps of a row's readings to their times.
Eigen::VectorXd ChannelProblem::DriftCorrection_deg() const {
  const auto from_stamp_deg = [&](const SensorState& node) {
    return -TurnedOn(node, channel_, -node.drift_correction_s);
  };
  Eigen::VectorXd out(rows());
  for (Eigen::Index i = 0; i < rows(); ++i)
    out(i) = from_stamp_deg(end_node(i)) - from_stamp_deg(history(i).nodes[ref(i).interval]);
  // Where the gyro does not say how it turned nothing is known of it.
  return out.unaryExpr([](double value) { return std::isfinite(value) ? value : 0.0; });
}

Eigen::VectorXd ChannelProblem::Turn(std::size_t axis) const {
  Eigen::VectorXd turn_deg = TurnByRates(axis);
  if (axis == channel_ || angle_errors_[axis] == nullptr) return turn_deg;
  for (Eigen::Index i = 0; i < rows(); ++i)
    turn_deg(i) += angle_errors_[axis]->turn_beyond_deg[ref(i).history][ref(i).interval];
  return turn_deg;
}

Eigen::MatrixXd ChannelProblem::ColumnsOf(const MisreadAxis& misread) const {
  BasisContext context = misread.context;
  context.channel = channel_;
  // Where a measurement does not say the axis's angle, nothing is felt of it.
  return misread_scale_ * Columns(*misread.effect, context).unaryExpr([](double value) {
    return std::isfinite(value) ? value : 0.0;
  });
}

void ChannelProblem::TakeOffMisread(const Vector3& row_of_m) {
  misread_scale_ = row_of_m[channel_];
  for (const MisreadAxis& misread : misread_) output_ -= ColumnsOf(misread) * misread.values;
}

Eigen::MatrixXd ChannelProblem::MisreadDeviations() const {
  Eigen::MatrixXd out(rows(), 0);
  for (const MisreadAxis& misread : misread_) {
    const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> parts(misread.covariance);
    const Eigen::VectorXd deviations = parts.eigenvalues().cwiseMax(0.0).cwiseSqrt();
    const Eigen::Index before = out.cols();
    out.conservativeResize(Eigen::NoChange, before + deviations.size());
    out.rightCols(deviations.size()) =
        ColumnsOf(misread) * parts.eigenvectors() * deviations.asDiagonal();
  }
  return out;
}

std::vector<std::string> ChannelProblem::NamesOfMisreadDeviations() const {
  std::vector<std::string> names;
  for (const MisreadAxis& misread : misread_) {
    for (Eigen::Index k = 0; k < misread.values.size(); ++k)
      names.push_back(fmt::format("{}({}) {} {}", misread.effect->id,
                                  fmt::join(misread.context.nonlinear, ","),
                                  misread.context.table_axis, k));
  }
  return names;
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
      const double after_s = error == nullptr ? 0.0 : DelayLeft_s(error->delays, point);
      const double shown = AccelerationAfter_deg_s2(point, channel_, after_s);
      return std::isfinite(shown) ? shown : 0.0;
    };
    const std::size_t interval = ref(i).interval;
    out(i) = at(interval + 1) - at(interval);
  }
  return out;
}

}  // namespace gyrobench::calibration
