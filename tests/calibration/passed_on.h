// A measurement on its way to another sink, as it is: what a test changes of it is overridden.
#pragma once

#include <span>

#include "base/measurement.h"

namespace gyrobench::testing {

class PassedOn : public MeasurementSink {
 public:
  explicit PassedOn(MeasurementSink& next) : next_(next) {}
  void OnInfo(const MeasurementInfo& info) override { next_.OnInfo(info); }
  void OnGyro(const GyroSample& sample) override { next_.OnGyro(sample); }
  void OnCovariates(double t_s, std::span<const double> values) override {
    next_.OnCovariates(t_s, values);
  }
  void OnAngle(const AngleSample& sample) override { next_.OnAngle(sample); }
  void OnOrientation(const OrientationSample& sample) override { next_.OnOrientation(sample); }
  void OnTickPair(const TickPair& pair) override { next_.OnTickPair(pair); }
  void OnSegment(const SegmentMark& mark) override { next_.OnSegment(mark); }
  void OnDefect(const Defect& defect) override { next_.OnDefect(defect); }

 private:
  MeasurementSink& next_;
};

}  // namespace gyrobench::testing
