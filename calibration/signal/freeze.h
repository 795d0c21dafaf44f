// Whether the sensor repeated itself because it hung, or because it had nothing else to say.
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "base/measurement.h"
#include "calibration/signal/columns.h"

namespace gyrobench::calibration {

// Stretches in which all channels, those of the accelerometer among them, repeat to the last digit:
// 25 samples and 0.3 s at least (2 s where there is one channel, whose filter may leave less noise
// than a count). Such a stretch is a freeze where the sensor's noise would have shown:
//   - the gyro's last digit is finer than 0.02 deg/s. The white noise of MEMS gyros, at least
//     0.002 deg/sqrt(s), is 0.01 deg/s in the narrowest usual band of 5 Hz, and three channels
//     that all stay within a digit of twice that for 0.3 s are not met; or
//   - the digit is coarser, but about the same level (within 1 deg/s or 5 digits) the sensor has
//     shown noise of three digits and more in at least three windows of that length, in twice as
//     many as it showed a flickering last digit, and in a quarter as many as it stood still; or
//   - the output then leaves the level by more than 5000 deg/s2 would in one interval, as it does
//     when it wakes in the middle of a motion; or
//   - nothing ever changed.
// A sensor with a digit of 0.1 deg/s at rest is none of these: its outputs are what it measured.
class FreezeWatch {
 public:
  struct Finding {
    double begin_s = 0.0, end_s = 0.0;
    std::int64_t samples = 0;
  };

  void Start(const MeasurementInfo& info);
  // `sample` as it came; `t_s`: its mended time.
  void Add(double t_s, const GyroSample& sample);
  // So far, in the order of time.
  std::vector<Finding> Found() const;
  // The gyro's last digit: of counts by the nominal sensitivity, else the least step so far, 0
  // before the first.
  double digit_deg_s() const;

 private:
  static constexpr std::size_t kLevels = 16;
  struct Level {
    Vector3 rate_deg_s = {};
    std::int64_t still = 0, flickering = 0, noisy = 0;  // windows
  };
  struct Run : Finding {
    Vector3 rate_deg_s = {};
    bool woke_with_a_jump = false;
  };
  struct Window {
    std::int64_t samples = 0;
    double begin_s = 0.0;
    Vector3 low = {}, high = {};
  };

  Vector3 Rates(const GyroSample& sample) const;
  bool IsLong(const Run& run) const;
  void EndRun(double t_s, const Vector3& next_deg_s);
  void Look(double t_s, const Vector3& rate_deg_s);
  void Classify();
  Level* LevelAt(const Vector3& rate_deg_s);
  bool SameLevel(const Vector3& a, const Vector3& b) const;
  bool IsFreeze(const Run& run) const;

  MeasurementInfo info_;
  double to_deg_s_ = 1.0;
  std::optional<GyroSample> last_;
  Run run_;
  int channels_ = 0;             // with a value in this run
  std::vector<Run> runs_;        // long ones that have ended
  double least_step_deg_s_ = 0;  // 0: nothing changed yet
  Window window_;
  std::vector<Level> levels_;
};

}  // namespace gyrobench::calibration
