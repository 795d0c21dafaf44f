// The accelerometer: where the sensor was held still, what it felt there and what the reference
// says; its calibration from these poses, and the correction of its samples by that.
#pragma once

#include <Eigen/Core>
#include <array>
#include <optional>
#include <span>
#include <vector>

#include "base/measurement.h"
#include "calibration/sensor/vector_calibration.h"

namespace gyrobench::calibration {

struct StateHistory;

struct Pose {
  Eigen::Vector3d accel_g = Eigen::Vector3d::Constant(kMissing);
  // By the reference, of length 1; NaN where it gives no orientation: gravity is then the
  // accelerometer's own, and no second opinion.
  Eigen::Vector3d gravity_g = Eigen::Vector3d::Constant(kMissing);
  double variance_g2 = kMissing;  // of a component of accel_g, by the noise within the rests
};

// One a rest of at least half a second, of all measurements.
std::vector<Pose> FindPoses(std::span<const StateHistory> histories);

// By least squares of accel = M g + offset against the reference's gravity, poses weighted by their
// noise and by a scatter from pose to pose where the residual shows one; and by |g| = 1 alone. What
// the poses do not show is NaN, and said. nullopt where no accelerometer was at rest.
std::optional<AccelerometerCalibration> CalibrateAccelerometer(std::span<const Pose> poses);

// Scale, offset and non-orthogonality (AxisSplit's) for which the corrected acceleration has size 1
// in every pose: with u = (accel - offset) / scale and G of the non-orthogonality,
//   sqrt(u^T G^-1 u) = 1
// by Gauss-Newton. Nine numbers take nine poses and more; six along the axes do not show the
// angles. What is not shown is NaN. `scatter_g2`: variance from pose to pose beyond the noise.
GravityCheck CheckGravity(std::span<const Pose> poses, double scatter_g2);

// g = M^-1 (accel - offset), in the frame N in which rates and g-sensitivities are. Samples stay as
// they are where the calibration has no accelerometer, or not all of its matrix.
class AccelCorrection {
 public:
  explicit AccelCorrection(const std::optional<VectorCalibration>& vector);
  std::array<double, 3> Apply(const std::array<double, 3>& accel_g) const;

 private:
  bool calibrated_ = false;
  Eigen::Matrix3d inverse_ = Eigen::Matrix3d::Identity();
  Eigen::Vector3d offset_ = Eigen::Vector3d::Zero();
};

}  // namespace gyrobench::calibration
