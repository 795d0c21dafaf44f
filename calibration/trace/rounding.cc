#include "calibration/trace/rounding.h"

#include <algorithm>
#include <cmath>

namespace gyrobench::calibration {

bool MayBeRounding(const ChannelProblem& problem, const Eigen::VectorXd& residual_deg) {
  constexpr double kWindow_s = 1.0;
  const double most_deg_s = 2.0 * problem.output_rounding_deg_s();
  if (!(most_deg_s > 0.0)) return false;
  double angle_deg = 0.0, length_s = 0.0;
  for (Eigen::Index i = 0; i < problem.rows(); ++i) {
    angle_deg += residual_deg(i);
    length_s += problem.intervals()[static_cast<std::size_t>(i)].duration_s;
    if (length_s < kWindow_s) continue;
    if (!(std::fabs(angle_deg) <= most_deg_s * length_s)) return false;
    angle_deg = length_s = 0.0;
  }
  return true;
}

}  // namespace gyrobench::calibration
