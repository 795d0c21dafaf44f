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
    case Verdict::kCannotBe:
      return "cannot_be";
  }
  return "";
}

bool IsTraced(const ChannelTrace& channel) {
  return channel.verdict != Verdict::kNone || std::isfinite(channel.baseline.whitened_rms);
}

void Condemn(const std::array<bool, 3>& axes, const std::string& says, TraceResult* result) {
  for (ChannelTrace& channel : result->channels) {
    if (!axes[static_cast<std::size_t>(channel.axis)] || !IsTraced(channel)) continue;
    channel.verdict = Verdict::kCannotBe;
    channel.summary = says + ".";
    if (channel.summary.front() >= 'a' && channel.summary.front() <= 'z')
      channel.summary.front() = static_cast<char>(channel.summary.front() - 'a' + 'A');
  }
}

}  // namespace gyrobench::calibration
