// What the rounding of the gyro's output may make.
#include <algorithm>
#include <cmath>

#include "calibration/trace/selection.h"

namespace gyrobench::calibration {

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
