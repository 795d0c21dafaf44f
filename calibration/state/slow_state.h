// The slow part of the state, from the sensor's own samples: temperature and its rate, gravity,
// vibration, further columns. As the tracer sees them, but with a bounded look ahead.
#pragma once

#include <cstddef>
#include <deque>
#include <span>
#include <vector>

#include "base/measurement.h"
#include "calibration/state/sensor_state.h"

namespace gyrobench::calibration {

// Means over 0.1 s; the temperature and its rate by lines through what lies within 5 s of each
// (slow_quantity.h); in between linear. What is missing is bridged where the gap is short, and NaN
// where it is not (state/slow_quantity.h), but for gravity, which is as it was last.
class SlowState {
 public:
  static constexpr double kNode_s = 0.1;
  static constexpr double kHalfWindow_s = 5.0;

  explicit SlowState(std::size_t covariates);

  // In the order of time.
  void Add(const GyroSample& sample, std::span<const double> covariates);
  void End();
  // The state at that time will not change by samples to come. While a column is missing, that may
  // take kLongestBridge_s.
  bool Knows(double t_s) const;
  // Fills temperature_degC, temperature_rate_degC_s, gravity_g, vibration_g2 and covariates of
  // `point`; NaN where not known. To be asked in the order of time, for times that are known; the
  // covariates hold until the next call.
  void At(double t_s, SensorState* point);

 private:
  struct Mean {
    double sum = 0.0, n = 0.0;
    void Add(double value);
    double Take();
  };
  // The temperature, then the covariates: their last known value.
  struct Column {
    Mean mean;
    double last_s = kMissing, last = kMissing;
  };
  struct Node {
    double t_s = 0.0, end_s = 0.0;  // middle, end
    Vector3 gravity_g = {kMissing, kMissing, kMissing};
    double vibration_g2 = kMissing;
    std::vector<double> value;   // of each column
    std::vector<bool> tellable;  // of each column
    double smooth_degC = kMissing, rate_degC_s = kMissing;
  };

  void CloseNode();
  double TakeVibration();
  Vector3 TakeGravity();
  void Settle(std::size_t column);
  double SettledUntil() const;
  void Smooth();

  std::deque<Node> nodes_;
  std::size_t smooth_ = 0;  // nodes_[0 .. smooth_ - 1] are smoothed
  bool ended_ = false;
  // Of the node that is being filled.
  bool open_ = false;
  double begin_s_ = 0.0, last_s_ = 0.0;
  std::vector<Column> columns_;
  std::array<Mean, 3> accel_, square_;
  Vector3 origin_ = {};
  Vector3 held_gravity_ = {kMissing, kMissing, kMissing};  // last known
  std::vector<double> now_;                                // covariates
};

}  // namespace gyrobench::calibration
