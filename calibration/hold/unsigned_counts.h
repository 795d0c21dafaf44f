// Counts of an unsigned converter, whose zero is in the middle of 16 bits.
#pragma once

#include <array>
#include <vector>

#include "base/measurement.h"

namespace gyrobench::calibration {

// Takes 32768 off the gyro's channels whose first samples lie about it. A signed sensor that stands
// there would be at three quarters of its range at rest, which none is allowed to be. The first
// samples are held back until it is decided.
class UnsignedCounts {
 public:
  void Start(const MeasurementInfo& info) { counts_ = info.gyro_unit == GyroUnit::kLsb; }
  // Samples that are ready, in order.
  std::vector<GyroSample> Add(const GyroSample& sample);
  // Those that still wait for a decision.
  std::vector<GyroSample> Flush();
  bool recognised() const { return zero_[0] != 0.0 || zero_[1] != 0.0 || zero_[2] != 0.0; }

 private:
  void Decide();
  GyroSample Centred(GyroSample sample) const;

  bool counts_ = false, decided_ = false;
  std::array<double, 3> zero_ = {};
  std::vector<GyroSample> waiting_;
};

}  // namespace gyrobench::calibration
