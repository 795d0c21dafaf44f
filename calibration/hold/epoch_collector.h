// A measurement of held poses in, epochs out.
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstddef>
#include <deque>
#include <optional>

#include "calibration/hold/epoch.h"
#include "calibration/signal/gyro_stream.h"
#include "calibration/signal/intake.h"

namespace gyrobench::calibration {

// Takes the events of one measurement, in order. Angles and orientations of a reference are not
// looked at: gravity is the reference here.
class EpochCollector : public MeasurementSink {
 public:
  // Shortest epoch; one of a slow gyro lasts from one sample to the next. At 300 deg/s an axis
  // turns by 15 deg in it, which the coning term holds to 1e-4 deg.
  static constexpr double kEpoch_s = 0.05;

  void OnInfo(const MeasurementInfo& info) override;
  void OnGyro(const GyroSample& sample) override;
  void OnAngle(const AngleSample& /*sample*/) override {}
  void OnOrientation(const OrientationSample& /*sample*/) override {}
  void OnTickPair(const TickPair& /*pair*/) override {}
  void OnSegment(const SegmentMark& /*mark*/) override {}
  void OnDefect(const Defect& defect) override;

  // What has been collected so far. Changes nothing.
  HoldRecording Take() const;

 private:
  // What the accelerometer and the thermometer say until the gyro's samples are settled.
  struct Beside {
    double t_s = 0.0;
    Eigen::Vector3d accel_g;
    double temperature_degC = kMissing;
  };

  // Differences of consecutive samples, up to an order that lets pass what is above some 0.4 of the
  // sample rate, and of 100 samples a second 1/5000 of an amplitude at 10 Hz. A hand trembles below.
  class HighDifference {
   public:
    static constexpr std::size_t kOrder = 8;
    static constexpr double kGain = 12870.0;  // sum of the squared binomials: of white noise
    void Restart() { samples_ = 0; }
    // The square of the difference that ends with this sample, over kGain; nothing with too few.
    std::optional<double> Next(const Eigen::Vector3d& xi);

   private:
    std::array<Eigen::Vector3d, kOrder> last_ = {};  // last_[k]: the newest k-th difference
    std::size_t samples_ = 0;
  };

  void TakeSettled();
  void AddInterval(const GyroRing::Point& from, const GyroRing::Point& to);
  void Close();
  void MeansUntil(double end_s, Epoch* epoch);

  MeasurementInfo info_;
  GyroStream gyro_;
  DefectLog reported_;
  std::vector<Epoch> epochs_;
  std::deque<Beside> beside_;
  Epoch open_;
  bool is_open_ = false;
  HighDifference high_;
  std::int64_t next_ = 1;  // sample of the ring that ends the next interval
  std::int64_t accel_samples_ = 0;
};

}  // namespace gyrobench::calibration
