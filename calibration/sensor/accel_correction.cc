#include "calibration/sensor/accel_correction.h"

#include <Eigen/LU>
#include <cmath>

namespace gyrobench::calibration {

AccelCorrection::AccelCorrection(const std::optional<VectorCalibration>& vector) {
  constexpr double kLeastVolume = 1e-3;
  if (!vector || !vector->accelerometer) return;
  const AccelerometerCalibration& accelerometer = *vector->accelerometer;
  Eigen::Matrix3d m;
  Eigen::Vector3d offset;
  for (std::size_t i = 0; i < 3; ++i) {
    const auto row = static_cast<Eigen::Index>(i);
    for (std::size_t j = 0; j < 3; ++j)
      m(row, static_cast<Eigen::Index>(j)) = accelerometer.m[i][j];
    offset[row] = accelerometer.offset_g[i];
  }
  if (!offset.allFinite() || !(std::fabs(m.determinant()) > kLeastVolume)) return;
  calibrated_ = true;
  inverse_ = m.inverse();
  offset_ = offset;
}

std::array<double, 3> AccelCorrection::Apply(const std::array<double, 3>& accel_g) const {
  if (!calibrated_) return accel_g;
  const Eigen::Vector3d corrected =
      inverse_ * (Eigen::Vector3d(accel_g[0], accel_g[1], accel_g[2]) - offset_);
  return {corrected[0], corrected[1], corrected[2]};
}

}  // namespace gyrobench::calibration
