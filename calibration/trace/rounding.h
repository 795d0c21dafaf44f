// What the rounding of the gyro's output to its last digit may pass for.
#pragma once

#include <Eigen/Core>

#include "calibration/trace/problem.h"

namespace gyrobench::calibration {

// Whether a residual [deg] is nowhere more than the rounding may leave: so are its means over 1 s,
// each of them, beside a zero-rate offset that was rounded as well. Where the noise of the output
// is larger than its last digit nothing is.
bool MayBeRounding(const ChannelProblem& problem, const Eigen::VectorXd& residual_deg);

}  // namespace gyrobench::calibration
