// A measurement in, columns out: the part of every analysis that sees samples.
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "base/measurement.h"
#include "base/tick_fit.h"
#include "calibration/signal/clock_drift.h"
#include "calibration/signal/columns.h"
#include "calibration/signal/late_rows.h"
#include "calibration/signal/output_digits.h"
#include "calibration/signal/stamp_line.h"

namespace gyrobench::calibration {

// What is kept of one measurement.
struct Recording {
  MeasurementInfo info;
  Columns columns;
  TickFit ticks;
  std::int64_t samples = 0;
  std::vector<std::uint64_t> passages;  // of the gyro's output (fingerprints.h)
  std::int64_t reference_samples = 0;
  std::array<std::int64_t, 3> valid_samples = {};
  double first_time_s = 0.0, last_time_s = 0.0;
  double median_interval_s = kMissing;  // of the gyro
  StampSteps stamps;                    // of the gyro
  // Of those that came in packets (PacketStamps): how many, the interval of the clock behind them,
  // and the standard deviation of stamps about it.
  std::int64_t packed_samples = 0;
  double packed_interval_s = kMissing, packed_scatter_s = kMissing;
  DriftCorrection drift_correction;  // of the reference's readings
  // Whether rows come as unevenly as their stamps, which is known at the end alone.
  RowTiming rows;
  std::array<OutputRounding, 3> rounding;  // of each channel
  // Of the stand's axes (of a single-axis reference its one, of an orientation each of the
  // sensor's): the least difference of two readings in a row; infinite where there was none.
  Vector3 reference_step_deg = {};
  bool orientation_known = false;
  std::vector<Defect> defects;
};

// Takes the events of one measurement, in order. No sample is kept, only columns at about 10 Hz:
// what it holds is a function of the events so far and of nothing else.
class Collector : public MeasurementSink {
 public:
  static constexpr double kNode_s = 0.1;
  // `even`: what is known to come evenly, by Recording::rows of the same measurement.
  explicit Collector(double node_interval_s = kNode_s, const EvenRows& even = {});
  ~Collector() override;
  // A copy goes on by itself: a snapshot that can be evaluated while the original takes more.
  Collector(const Collector& other);
  Collector(Collector&&) noexcept;
  Collector& operator=(Collector&&) noexcept;

  void OnInfo(const MeasurementInfo& info) override;
  void OnGyro(const GyroSample& sample) override;
  void OnCovariates(double t_s, std::span<const double> values) override;
  void OnAngle(const AngleSample& sample) override;
  void OnOrientation(const OrientationSample& sample) override;
  void OnTickPair(const TickPair& pair) override;
  void OnSegment(const SegmentMark& mark) override;
  void OnDefect(const Defect& defect) override;

  // What has been collected so far, with the rest that is still going on. Changes nothing.
  Recording Take() const;

 private:
  class Impl;
  std::unique_ptr<Impl> impl_;
  EvenRows even_;
  double gyro_delay_s_ = 0.0, reference_delay_s_ = 0.0;
};

}  // namespace gyrobench::calibration
