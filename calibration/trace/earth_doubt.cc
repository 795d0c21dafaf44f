#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "calibration/effects/effect.h"
#include "calibration/trace/report_parts.h"
#include "kinematics/stand_frame.h"

namespace gyrobench::calibration {
namespace {

// At the pole all of it is along z.
double Earth_deg_s() { return kinematics::EarthRate(90.0, 0.0)[2]; }
// Standard errors within which a size is not certain.
constexpr double kCertain = 3.0;

bool Names(const TracedEffect& effect, const std::string& id) {
  return effect.id == id || std::ranges::find(effect.rivals, id) != effect.rivals.end();
}

}  // namespace

void AddEarthAsRival(TracedEffect* effect) {
  const std::string& earth = EarthRotationEffect().id;
  const Effect* known = FindEffect(effect->id);
  if (known == nullptr || !known->earth_passes_for_it || Names(*effect, earth)) return;
  // What one axis shows beyond doubt, another that is hardly seen does not bring into question.
  double square = 0.0, variance = 0.0, most = 0.0;
  for (const ModelParameter& parameter : effect->parameters) {
    if (!std::isfinite(parameter.std_error)) continue;  // not determined, and left at 0
    square += parameter.value * parameter.value;
    variance += parameter.std_error * parameter.std_error;
    most = std::max(most, std::fabs(parameter.value) - kCertain * parameter.std_error);
  }
  if (std::max(most, std::sqrt(square) - kCertain * std::sqrt(variance)) > Earth_deg_s()) return;
  effect->rivals.insert(std::ranges::upper_bound(effect->rivals, earth), earth);
}

std::string LatitudeNeeded(const std::vector<TracedEffect>& effects) {
  const bool doubted = std::ranges::any_of(
      effects, [](const TracedEffect& effect) { return Names(effect, EarthRotationEffect().id); });
  if (!doubted) return "";
  return fmt::format(
      "The site's latitude is needed: Earth's rotation ({:.2g} deg/s) is not taken off and passes "
      "for a sensitivity to gravity. Set site.latitude_deg in the stand file (site_latitude_deg in "
      "a table) and measure or trace again",
      Earth_deg_s());
}

}  // namespace gyrobench::calibration
