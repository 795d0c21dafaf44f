#include "calibration/trace/trace_result.h"

#include <algorithm>
#include <cmath>

namespace gyrobench::calibration {

double ShareOfError(const TracedEffect& effect) {
  const HeldOut& angle = effect.heldout_angle_rms_deg;
  if (!(angle.after > 0.0) || std::isnan(angle.before)) return kMissing;
  const double ratio = angle.before / angle.after;
  return std::sqrt(std::max(ratio * ratio - 1.0, 0.0));
}

const char* Name(Verdict verdict) {
  switch (verdict) {
    case Verdict::kNone:
      return "none";
    case Verdict::kExplained:
      return "explained";
    case Verdict::kPartlyExplained:
      return "partly_explained";
    case Verdict::kUnexplained:
      return "unexplained";
  }
  return "";
}

bool IsTraced(const ChannelTrace& channel) {
  return channel.verdict != Verdict::kNone || std::isfinite(channel.baseline.whitened_rms);
}

}  // namespace gyrobench::calibration
