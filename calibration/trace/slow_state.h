// The slow part of the state, from the sensor's own samples: temperature and its rate, gravity,
// vibration, further columns. As the tracer sees them, but with a bounded look ahead.
#pragma once

#include <cstddef>
#include <deque>
#include <span>
#include <vector>

#include "base/measurement.h"
#include "calibration/trace/track.h"

namespace gyrobench::calibration {

// Means over 0.1 s; the temperature and its rate by lines through what lies within 5 s of each
// (trace/smooth.h); in between linear. What is missing is as it was last.
class SlowState {
 public:
  static constexpr double kNode_s = 0.1;
  static constexpr double kHalfWindow_s = 5.0;

  explicit SlowState(std::size_t covariates);

  // In the order of time.
  void Add(const GyroSample& sample, std::span<const double> covariates);
  void End();
  // The state at that time will not change by samples to come.
  bool Knows(double t_s) const;
  // Fills temperature_degC, temperature_rate_degC_s, gravity_g, vibration_g2 and covariates of
  // `point`; NaN where not known. To be asked in the order of time, for times that are known; the
  // covariates hold until the next call.
  void At(double t_s, TrackPoint* point);

 private:
  struct Mean {
    double sum = 0.0, n = 0.0;
    void Add(double value);
    double Take();
  };
  struct Node {
    double t_s = 0.0, end_s = 0.0;  // middle, end
    double temperature_degC = kMissing;
    Vector3 gravity_g = {kMissing, kMissing, kMissing};
    double vibration_g2 = kMissing;
    double smooth_degC = kMissing, rate_degC_s = kMissing;
    std::vector<double> covariates;
  };

  void CloseNode();
  void Smooth();
  Vector3 TakeGravity();

  std::deque<Node> nodes_;
  std::size_t smooth_ = 0;  // nodes_[0 .. smooth_ - 1] are smoothed
  bool ended_ = false;
  // Of the node that is being filled.
  bool open_ = false;
  double begin_s_ = 0.0, last_s_ = 0.0;
  Mean temperature_;
  std::array<Mean, 3> accel_, square_;
  Vector3 origin_ = {};
  std::vector<Mean> covariates_;
  // Last known.
  double held_degC_ = kMissing, held_rate_ = kMissing;
  Vector3 held_gravity_ = {kMissing, kMissing, kMissing};
  std::vector<double> held_covariates_, now_;
};

}  // namespace gyrobench::calibration
