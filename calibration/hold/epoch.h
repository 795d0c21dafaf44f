// What is kept of a measurement of held poses: epochs of about 0.05 s. No sample is kept.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <optional>
#include <vector>

#include "base/measurement.h"
#include "calibration/signal/columns.h"

namespace gyrobench::calibration {

// The gyro's output over one epoch at full rate, as far as a rotation needs it for any matrix and
// any offset (turn_rotation.h). Output units: those of xi (LSB, deg/s), frame: the gyro's channels.
struct Epoch {
  double begin_s = 0.0, end_s = 0.0;
  // int xi dt over the epoch.
  Eigen::Vector3d angle = Eigen::Vector3d::Zero();
  // 1/2 int a(t) x xi(t) dt with a(t) the integral of xi since begin_s: what the turning of the
  // axis within the epoch adds to the rotation vector (coning).
  Eigen::Vector3d coning = Eigen::Vector3d::Zero();
  // int a(t) dt.
  Eigen::Vector3d moment = Eigen::Vector3d::Zero();
  // Mean of the specific force as the accelerometer gives it [g]; NaN where it gave none.
  Eigen::Vector3d accel_g = Eigen::Vector3d::Constant(kMissing);
  // Sum over samples and axes of the interval times the square of the 8th difference, divided by
  // the 12870 that white noise makes it larger by [output units^2 s], and how many samples.
  double white_square = 0.0;
  int white_samples = 0;
  double temperature_degC = kMissing;  // mean
  bool usable = true;                  // no gap, no saturation, nothing that is not a number

  double duration_s() const { return end_s - begin_s; }
  Eigen::Vector3d rate() const { return angle / duration_s(); }
};

// Takes a constant off the output that an epoch was integrated from, exactly.
inline void Detrend(const Eigen::Vector3d& constant, Epoch* epoch) {
  const double h = epoch->duration_s();
  epoch->coning += constant.cross(epoch->moment) - 0.5 * h * constant.cross(epoch->angle);
  epoch->moment -= 0.5 * h * h * constant;
  epoch->angle -= h * constant;
}

struct HoldRecording {
  MeasurementInfo info;
  std::vector<Epoch> epochs;
  std::vector<BadStretch> bad;
  std::vector<Defect> defects;
  std::int64_t samples = 0;
  std::array<std::int64_t, 3> valid_samples = {};
  std::int64_t accel_samples = 0;  // with all three axes
  double first_time_s = 0.0, last_time_s = 0.0;
  double median_interval_s = kMissing;
  // The converter's count of zero, which the epochs are free of: as given, else that of an unsigned
  // converter where the counts show one, else 0; empty where the output is no count.
  std::optional<double> gyro_lsb_zero;
};

}  // namespace gyrobench::calibration
