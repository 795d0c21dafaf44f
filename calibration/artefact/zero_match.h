// The converter's count of zero, of a calibration and of the data that it is applied to.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "base/geometry.h"
#include "base/measurement.h"
#include "calibration/artefact/calibration_file.h"

namespace gyrobench::calibration {

// A calibration is of counts less its `gyro_lsb_zero`; samples come less the zero that their table
// gives. Where the two differ, what is to be taken off besides is known at once if both zeros are
// given, and else by the samples: a logger that centres its counts writes no zero, and neither does
// one that nobody described. Then the first samples decide, by which of the two the calibration
// makes the smaller rate of most of them.
class ZeroMatch {
 public:
  ZeroMatch(const Calibration& calibration, const MeasurementInfo& info);

  // The next sample, in the unit of the data; has no effect once it is decided.
  void Watch(const Vector3& xi);
  bool decided() const { return decided_; }
  // No more samples, or no time to wait for more.
  void Decide();
  // To be taken off each sample, once it is decided.
  double off() const { return off_; }
  // What to say of it; empty where nothing differs.
  std::string Remark() const;

 private:
  struct Axis {
    std::size_t channel = 0;
    double units_per_deg_s = 1.0, bias_deg_s = 0.0;
  };
  std::string name_;
  std::vector<Axis> axes_;
  double calibrated_zero_ = 0.0;
  double off_ = 0.0;
  double difference_ = 0.0;  // of the zeros: calibration's less table's
  bool decided_ = true;
  int samples_ = 0, for_difference_ = 0, against_ = 0;
};

}  // namespace gyrobench::calibration
