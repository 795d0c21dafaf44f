// The accelerometer's calibration from poses.
#pragma once

#include <optional>
#include <span>

#include "calibration/sensor/poses.h"
#include "calibration/sensor/vector_calibration.h"

namespace gyrobench::calibration {

// By least squares of accel = M g + offset against the reference's gravity, poses weighted by their
// noise and by a scatter from pose to pose where the residual shows one; and by |g| = 1 alone. What
// the poses do not show is NaN, and said. nullopt where no accelerometer was at rest.
std::optional<AccelerometerCalibration> CalibrateAccelerometer(std::span<const Pose> poses);

}  // namespace gyrobench::calibration
