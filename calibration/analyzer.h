// A measurement in, a result out: the analysis as a stream.
#pragma once

#include <memory>

#include "base/measurement.h"
#include "calibration/results.h"

namespace gyrobench::calibration {

struct AnalyzerOptions {
  double node_interval_s = 0.1;  // of the columns that are kept
  // Longest polynomial tried for the bias against temperature, 0..5.
  int max_bias_order = 5;
  // A range of temperature below this says nothing of how the bias depends on it.
  double min_temperature_range_degC = 1.0;
  // An axis that turned by less in all is not estimated.
  double min_rotation_deg = 5.0;
};

// Takes the events of one measurement, in order, and says at any moment what they amount to. No
// sample is kept, only columns at about 10 Hz. The result is a function of the events so far and of
// nothing else: the running daemon and a later analysis of the record agree to the last digit.
class Analyzer final : public MeasurementSink {
 public:
  explicit Analyzer(const AnalyzerOptions& options = {});
  ~Analyzer() override;
  // A copy goes on by itself: a snapshot that can be evaluated while the original takes more.
  Analyzer(const Analyzer& other);
  Analyzer(Analyzer&&) noexcept;
  Analyzer& operator=(Analyzer&&) noexcept;

  void OnInfo(const MeasurementInfo& info) override;
  void OnGyro(const GyroSample& sample) override;
  void OnAngle(const AngleSample& sample) override;
  void OnOrientation(const OrientationSample& sample) override;
  void OnTickPair(const TickPair& pair) override;
  void OnSegment(const SegmentMark& mark) override;
  void OnDefect(const Defect& defect) override;

  // What can be estimated so far; what cannot is said in the remarks. Changes nothing.
  // Throws DataError when there is nothing to analyse: no sample, or no usable one on any axis.
  AnalysisResult Result() const;

 private:
  class Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace gyrobench::calibration
