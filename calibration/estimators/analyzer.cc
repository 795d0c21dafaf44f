#include "calibration/estimators/analyzer.h"

#include <fmt/format.h>

#include "base/error.h"
#include "calibration/estimators/bias.h"
#include "calibration/estimators/plausibility.h"
#include "calibration/estimators/scale.h"
#include "calibration/estimators/schedule.h"
#include "calibration/signal/clock_offset.h"
#include "calibration/signal/intake.h"
#include "calibration/signal/reference_error.h"

namespace gyrobench::calibration {
namespace {

std::string SourceName(const MeasurementInfo& info) {
  return info.source.empty() ? "measurement" : info.source;
}

// Which channels have anything to say. Throws DataError when none has.
std::array<bool, 3> UsableChannels(const Recording& recording, std::vector<std::string>* remarks) {
  std::array<bool, 3> usable = {};
  RefuseNoSamples(SourceName(recording.info), recording.samples, recording.defects,
                  "a measurement with at least one axis");
  bool any = false;
  for (std::size_t c = 0; c < 3; ++c) {
    if (!recording.info.gyro_present[c]) continue;
    usable[c] = recording.valid_samples[c] > 1;
    any = any || usable[c];
    if (usable[c]) continue;
    remarks->push_back(
        fmt::format("gyro {}: no usable sample (of {})", "xyz"[c], recording.samples));
  }
  if (!any) {
    throw DataError(fmt::format(
        "{}: none of the {} gyro samples has a finite time and value; nothing can be estimated",
        SourceName(recording.info), recording.samples));
  }
  return usable;
}

}  // namespace

AnalysisResult Analyze(const Recording& recording, const AnalyzerOptions& options) {
  AnalysisResult result;
  result.info = recording.info;
  result.samples = recording.samples;
  result.reference_samples = recording.reference_samples;
  result.defects = recording.defects;
  const std::array<bool, 3> usable = UsableChannels(recording, &result.remarks);
  RefuseSamplesFarApart(recording);
  for (const std::string& remark : IntakeRemarks(recording)) result.remarks.push_back(remark);
  result.first_time_s = recording.first_time_s;
  result.duration_s = recording.last_time_s - recording.first_time_s;
  result.gyro_rate_hz = 1.0 / recording.median_interval_s;
  const Estimation estimation{
      recording.info, options, recording.columns, recording.ticks, recording.orientation_known,
      usable};
  RemarkOnReference(estimation, &result.remarks);
  result.scale =
      EstimateScale(estimation, &result.remarks, &result.unfollowed_deg, &result.defects);
  if (!result.scale.empty() && !recording.info.reference_uncertainty.said())
    result.remarks.emplace_back(kRelativeToReference);
  result.bias = EstimateBias(estimation, result.scale, &result.remarks, &result.defects);
  result.two_clocks = RemarkOnClocks(recording);
  std::vector<std::string> first = Implausible(result);
  if (!result.two_clocks.empty()) first.push_back(result.two_clocks);
  result.remarks.insert(result.remarks.begin(), first.begin(), first.end());
  return result;
}

}  // namespace gyrobench::calibration
