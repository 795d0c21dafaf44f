#include "calibration/artefact/calibration_file.h"

#include "calibration/artefact/calibration_fields.h"
#include "calibration/effects/effect.h"

namespace gyrobench::calibration {

bool ScaleUnknown(const ChannelModel& model) {
  return model.unit == "LSB" && model.units_per_deg_s == 1.0 &&
         model.m_row[static_cast<std::size_t>(model.axis)] == 0.0;
}

std::string WhyNotApplied(const ModelTerm& term) {
  if (term.owner == EffectOwner::kReference) return "an error of the reference, not of the gyro";
  if (term.owner == EffectOwner::kBench) return "an effect of the bench, not of the gyro";
  if (term.origin != EffectOrigin::kCatalogue) return "";
  const Effect* effect = FindEffect(CatalogueName(term.id), term.nonlinear.size());
  if (effect == nullptr) return "it is not in the catalogue of this version";
  if (effect->true_motion) return "Earth's rotation is true motion, not an error";
  if (effect->of_one_time()) return "its time and phase are of the run that it was found in";
  if (effect->domain == EffectDomain::kAngle) return "a lag cannot be undone sample by sample";
  return "";
}

nlohmann::json ToJson(const Calibration& calibration) { return WriteFields(calibration); }

}  // namespace gyrobench::calibration
