// Where the sensor was held still, what its accelerometer felt there, and what the reference says.
#pragma once

#include <Eigen/Core>
#include <span>
#include <vector>

#include "calibration/state/state_history.h"

namespace gyrobench::calibration {

struct Pose {
  Eigen::Vector3d accel_g = Eigen::Vector3d::Constant(kMissing);
  // By the reference, of length 1; NaN where it gives no orientation: gravity is then the
  // accelerometer's own, and no second opinion.
  Eigen::Vector3d gravity_g = Eigen::Vector3d::Constant(kMissing);
  double variance_g2 = kMissing;  // of a component of accel_g, by the noise within the rests
};

// One a rest of at least half a second, of all measurements.
std::vector<Pose> FindPoses(std::span<const StateHistory> histories);

}  // namespace gyrobench::calibration
