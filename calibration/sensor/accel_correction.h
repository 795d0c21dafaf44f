// An accelerometer's samples, corrected by its calibration.
#pragma once

#include <Eigen/Core>
#include <array>
#include <optional>

#include "calibration/sensor/vector_calibration.h"

namespace gyrobench::calibration {

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
