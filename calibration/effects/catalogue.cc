#include "calibration/effects/effect.h"
#include "calibration/effects/effect_tables.h"

namespace gyrobench::calibration {

const std::vector<Effect>& EffectCatalogue() {
  static const std::vector<Effect> catalogue = [] {
    std::vector<Effect> all = RateEffects();
    for (Effect& effect : AngleEffects()) all.push_back(std::move(effect));
    return all;
  }();
  return catalogue;
}

const Effect* FindEffect(const std::string& id, std::size_t nonlinear_parameters) {
  for (const Effect& effect : EffectCatalogue()) {
    if (effect.id == id && effect.nonlinear.size() == nonlinear_parameters) return &effect;
  }
  return nullptr;
}

}  // namespace gyrobench::calibration
