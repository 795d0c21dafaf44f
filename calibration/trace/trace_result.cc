#include "calibration/trace/trace_result.h"

#include <fmt/format.h>

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

std::string Message(const Unidentifiable& one) {
  if (!one.limit) return one.because;
  return fmt::format("{}: {:.2g} {}, of parts {:.2g}", one.because, one.limit->bound,
                     one.limit->unit, one.limit->largest);
}

bool IsTraced(const ChannelTrace& channel) {
  return channel.verdict != Verdict::kNone || std::isfinite(channel.baseline.whitened_rms);
}

}  // namespace gyrobench::calibration
