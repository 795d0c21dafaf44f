// A measurement in, a result out: the analysis as a stream.
#pragma once

#include "calibration/estimators/results.h"
#include "calibration/signal/collector.h"

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

// What can be estimated; what cannot is said in the remarks. A function of the recording and of
// nothing else: the running daemon and a later analysis of the record agree to the last digit.
// Throws DataError when there is nothing to analyse: no sample, or no usable one on any axis.
AnalysisResult Analyze(const Recording& recording, const AnalyzerOptions& options = {});

// A collector that is asked for its analysis directly.
class Analyzer final : public Collector {
 public:
  explicit Analyzer(const AnalyzerOptions& options = {})
      : Collector(options.node_interval_s), options_(options) {}
  AnalysisResult Result() const { return Analyze(Take(), options_); }

 private:
  AnalyzerOptions options_;
};

}  // namespace gyrobench::calibration
