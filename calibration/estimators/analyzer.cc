#include "calibration/estimators/analyzer.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "base/error.h"
#include "calibration/estimators/bias.h"
#include "calibration/estimators/plausibility.h"
#include "calibration/estimators/scale.h"
#include "calibration/estimators/schedule.h"
#include "calibration/gls/statistics.h"
#include "calibration/signal/clock_offset.h"
#include "calibration/signal/intake.h"
#include "calibration/signal/reference_error.h"
#include "calibration/signal/wrapped_counts.h"

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
  RefuseWrappedCounts(recording.info.source, recording.defects);
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

// Of one reading of the reference as the rests show it [deg]: its scatter or its rounding,
// whichever is larger; NaN without rests.
double ReadingError(const Recording& recording) {
  double error_deg = kMissing;
  for (const Rest& rest : recording.columns.rests)
    error_deg = std::fmax(error_deg, rest.scatter_deg);
  if (std::isnan(error_deg)) return error_deg;
  // Steps that no reading at rest crosses.
  constexpr double kCoarsest_deg = 1.0;
  for (const double step_deg : recording.reference_step_deg) {
    if (step_deg < kCoarsest_deg) error_deg = std::max(error_deg, step_deg / std::sqrt(12.0));
  }
  return error_deg;
}

// Where the offset is another in each rest, it is in each turn as well. The fit of the scale factor
// follows it as a walk: its bias is the mean of the offsets that were there, which is known well,
// and its noise is that of no sensor.
void AllowForOffsets(const std::vector<BiasResult>& biases, std::vector<ScaleResult>* scales) {
  for (ScaleResult& scale : *scales) {
    const auto bias = std::ranges::find(biases, scale.axis, &BiasResult::axis);
    if (bias == biases.end() || !(bias->offset_scatter > 0.0)) continue;
    const auto groups = static_cast<double>(bias->offset_groups);
    const double of_mean =
        bias->offset_scatter / std::sqrt(groups) * StudentInflation(std::max(groups - 1.0, 2.0));
    scale.bias_std_error = std::hypot(scale.bias_std_error, of_mean);
    scale.noise.angle_random_walk_deg_sqrt_s = bias->noise.angle_random_walk_deg_sqrt_s;
    scale.noise.bias_random_walk_deg_s_sqrt_s = bias->noise.bias_random_walk_deg_s_sqrt_s;
    scale.noise_of_rests = true;
    scale.remarks.push_back(
        fmt::format("the offset differs from rest to rest by {:.3g} {} rms (see the bias): the "
                    "bias here is the mean over turns and rests, and its error allows for that",
                    bias->offset_scatter, bias->unit));
  }
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
  const Estimation estimation{recording.info,
                              options,
                              recording.columns,
                              recording.ticks,
                              recording.orientation_known,
                              usable,
                              ReadingError(recording)};
  RemarkOnReference(estimation, &result.remarks);
  result.scale =
      EstimateScale(estimation, &result.remarks, &result.unfollowed_deg, &result.defects);
  if (!result.scale.empty() && !recording.info.reference_uncertainty.said())
    result.remarks.emplace_back(kRelativeToReference);
  result.bias = EstimateBias(estimation, result.scale, &result.remarks, &result.defects);
  AllowForOffsets(result.bias, &result.scale);
  result.two_clocks = RemarkOnClocks(recording);
  result.faults = FaultsIn(recording);
  for (const SensorAxis axis : ImplausibleAxes(result))
    result.cause[static_cast<std::size_t>(axis)] = CauseIn(recording, axis);
  std::vector<std::string> first = Implausible(result);
  const bool a_fault = std::ranges::find(result.faults, result.two_clocks) != result.faults.end();
  if (!result.two_clocks.empty() && !a_fault) first.push_back(result.two_clocks);
  result.remarks.insert(result.remarks.begin(), first.begin(), first.end());
  return result;
}

}  // namespace gyrobench::calibration
