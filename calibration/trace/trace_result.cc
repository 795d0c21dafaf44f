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

const char* Name(EffectOwner owner) {
  switch (owner) {
    case EffectOwner::kGyro:
      return "gyro";
    case EffectOwner::kReference:
      return "reference";
    case EffectOwner::kBench:
      return "bench";
  }
  return "";
}

const char* Name(EffectOrigin origin) {
  switch (origin) {
    case EffectOrigin::kCatalogue:
      return "catalogue";
    case EffectOrigin::kComposed:
      return "composed";
    case EffectOrigin::kEmpirical:
      return "empirical";
  }
  return "";
}

const char* Name(ChosenOn chosen_on) {
  return chosen_on == ChosenOn::kTrainingPart ? "training_part" : "all_data";
}

bool IsTraced(const ChannelTrace& channel) {
  return channel.verdict != Verdict::kNone || std::isfinite(channel.baseline.whitened_rms);
}

}  // namespace gyrobench::calibration
