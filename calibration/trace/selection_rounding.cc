// What the rounding of the gyro's output, and that of the reference's readings, may make.
#include <algorithm>
#include <cmath>

#include "calibration/trace/selection.h"

namespace gyrobench::calibration {
namespace {

// Root mean square of what is left of a ripple in the means of a node's readings, over the nodes
// at which its axis turns: of many periods between readings most may be gone.
double LeftInMeans(const ChannelProblem& problem, const Candidate& ripple) {
  const std::size_t axis = ripple.context.table_axis;
  double square = 0.0, nodes = 0.0;
  for (const StateHistory& history : problem.histories()) {
    for (const SensorState& node : history.nodes) {
      if (!(std::fabs(node.table_rate_deg_s[axis]) > 0.0)) continue;
      const auto readings = static_cast<double>(node.readings);
      const double half_step =
          0.5 * ripple.context.nonlinear[0] * node.reading_step_deg[axis] * kRadPerDeg;
      const double one = std::sin(half_step);
      square += one != 0.0 ? std::pow(std::sin(readings * half_step) / (readings * one), 2) : 1.0;
      nodes += 1.0;
    }
  }
  return nodes > 0.0 ? std::sqrt(square / nodes) : 1.0;
}

}  // namespace

// The error e of a reading is in the output and in the angle that a wave is a function of: the mean
// of e sin(k (phi + e)) is a wave of the size k e^2. The angle is known better than by one reading
// where the gyro carries it: so much it is at most. What rounding makes is a wave as well, of as
// many periods a turn as the encoder has steps; at even times it passes for one of fewer, and for a
// larger one where that would hardly be left in the means of readings.
double Selection::LeastRipple_deg(const Candidate& ripple) const {
  constexpr double kClearly = 3.0;
  // Half a step, which rounding never errs by more than, is so many times the first harmonic.
  constexpr double kAllHarmonics = 1.6;
  const std::size_t axis = ripple.context.table_axis;
  const double error_deg = problem_->angle_error_deg(axis);
  const double wave_deg = problem_->rounding_wave_deg(axis);
  return std::max(kClearly * ripple.context.nonlinear[0] * error_deg * error_deg * kRadPerDeg,
                  wave_deg > 0.0 ? kAllHarmonics * wave_deg / LeftInMeans(*problem_, ripple) : 0.0);
}

// What a candidate adds beside the others is nowhere larger than the wave which rounding makes of
// the rate, or, where it follows the rate, explains no more than such a wave in all rows would: at
// the few speeds and offsets of a table the wave passes for any of them.
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
  double largest_deg_s = 0.0, all_s = 0.0;
  for (Eigen::Index i = 0; i < turned_deg.size(); ++i) {
    const double duration_s = problem_->intervals()[static_cast<std::size_t>(i)].duration_s;
    largest_deg_s = std::max(largest_deg_s, std::fabs(turned_deg(i)) / duration_s);
    all_s += duration_s;
  }
  if (largest_deg_s < wave_deg_s) return true;
  const bool of_rate = candidate.effect == nullptr || (candidate.effect->needs & kNeedsRate) != 0;
  const double of_wave = 0.5 * std::pow(wave_deg_s / walk_deg_sqrt_s_, 2) * all_s;
  return of_rate && Cost(others) - Cost(model) < of_wave;
}

}  // namespace gyrobench::calibration
