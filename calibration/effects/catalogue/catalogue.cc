#include <fmt/format.h>

#include <algorithm>
#include <ranges>

#include "calibration/effects/catalogue/makers.h"

namespace gyrobench::calibration {
const std::vector<Effect>& EffectCatalogue() {
  static const std::vector<Effect> catalogue = [] {
    std::vector<Effect> all;
#define GYROBENCH_MAKE(name) all.push_back(name());
    GYROBENCH_EFFECTS(GYROBENCH_MAKE)
#undef GYROBENCH_MAKE
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

const Effect* FindEffect(const std::string& id) {
  for (const Effect& effect : EffectCatalogue()) {
    if (effect.id == id) return &effect;
  }
  return nullptr;
}

std::string ManoeuvreFor(const Effect& effect, const std::string& column) {
  return fmt::format(fmt::runtime(effect.manoeuvre), column);
}

std::string CatalogueName(const std::string& id) { return id.substr(0, id.find('(')); }

std::string ManoeuvreOf(const std::string& id) {
  const std::string name = CatalogueName(id);
  const Effect* effect = FindEffect(name);
  if (effect == nullptr) return "";
  if (name == id) return ManoeuvreFor(*effect);
  return ManoeuvreFor(*effect, id.substr(name.size() + 1, id.size() - name.size() - 2));
}

const Effect& ScannedEffect(Search search, EffectDomain domain) {
  return *std::ranges::find_if(EffectCatalogue(), [&](const Effect& one) {
    return one.search == search && one.domain == domain;
  });
}

}  // namespace gyrobench::calibration
