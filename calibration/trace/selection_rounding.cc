// What the rounding of the gyro's output, and that of the reference's readings, may make.
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>

#include "base/geometry.h"
#include "calibration/effects/basis.h"
#include "calibration/gls/scaled_ldlt.h"
#include "calibration/trace/selection.h"

namespace gyrobench::calibration {
namespace {

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

}  // namespace

// The error e of a reading is in the output and in the angle that a wave is a function of: the mean
// of e sin(k (phi + e)) is a wave of the size k e^2. The angle is known better than by one reading
// where the gyro carries it: so much it is at most. What rounding makes is a wave as well, of as
// many periods a turn as the encoder has steps; at even times it passes for one of fewer, and for a
// larger one where that would hardly be left in the means of readings.
bool Selection::MayBeOfReadings(const Candidate& ripple, double amplitude_deg) const {
  constexpr double kClearly = 3.0;
  // Half a step, which rounding never errs by more than, is so many times the first harmonic.
  constexpr double kAllHarmonics = 1.6;
  const std::size_t axis = ripple.context.table_axis;
  const double error_deg = problem_->angle_error_deg(axis);
  const double of_error_deg =
      kClearly * ripple.context.nonlinear[0] * error_deg * error_deg * kRadPerDeg;
  const double of_rounding_deg = kAllHarmonics * problem_->rounding_wave_deg(axis);
  if (amplitude_deg < std::max(of_error_deg, of_rounding_deg)) return true;
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
