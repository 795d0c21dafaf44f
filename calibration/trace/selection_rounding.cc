// What the rounding of the gyro's output may make.
#include <algorithm>
#include <cmath>

#include "calibration/trace/selection.h"

namespace gyrobench::calibration {

// A change of the output that is nowhere larger than the wave which rounding makes of the rate: at
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
  double largest_deg_s = 0.0;
  for (Eigen::Index i = 0; i < turned_deg.size(); ++i) {
    const double duration_s = problem_->intervals()[static_cast<std::size_t>(i)].duration_s;
    largest_deg_s = std::max(largest_deg_s, std::fabs(turned_deg(i)) / duration_s);
  }
  return largest_deg_s < wave_deg_s;
}

}  // namespace gyrobench::calibration
