#include "calibration/effects/effect_kind.h"

namespace gyrobench::calibration {

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

}  // namespace gyrobench::calibration
