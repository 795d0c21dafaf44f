// The accelerometer against the size of gravity alone.
#pragma once

#include <span>

#include "calibration/sensor/poses.h"
#include "calibration/sensor/vector_calibration.h"

namespace gyrobench::calibration {

// Scale, offset and non-orthogonality (AxisSplit's) for which the corrected acceleration has size 1
// in every pose: with u = (accel - offset) / scale and G of the non-orthogonality,
//   sqrt(u^T G^-1 u) = 1
// by Gauss-Newton. Nine numbers take nine poses and more; six along the axes do not show the
// angles. What is not shown is NaN. `scatter_g2`: variance from pose to pose beyond the noise.
GravityCheck CheckGravity(std::span<const Pose> poses, double scatter_g2);

}  // namespace gyrobench::calibration
