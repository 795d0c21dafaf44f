#include <fmt/format.h>

#include <algorithm>
#include <string>
#include <string_view>
#include <vector>

#include "calibration/effects/effect.h"
#include "calibration/trace/channel_report.h"
#include "calibration/trace/report_parts.h"
#include "kinematics/stand_frame.h"

namespace gyrobench::calibration {
namespace {

bool Names(const TracedEffect& effect, const std::string& id) {
  return effect.id == id || std::ranges::find(effect.rivals, id) != effect.rivals.end();
}

// The axis of gravity that a parameter of the g-sensitivity belongs to: 2 of "k_z" and of
// "bias.g_linear.k_z"; 3 of another parameter.
std::size_t AxisOf(std::string_view name) {
  const std::vector<EffectTerm>& terms = GSensitivityEffect().terms;
  const std::string prefix = GSensitivityEffect().id + ".";
  if (name.starts_with(prefix)) name.remove_prefix(prefix.size());
  return static_cast<std::size_t>(std::ranges::find(terms, name, &EffectTerm::name) -
                                  terms.begin());
}

}  // namespace

// At the pole all of it is along z.
double EarthRate_deg_s() { return kinematics::EarthRate(90.0, 0.0)[2]; }

void AddEarthError(TracedChannel* traced) {
  const GravityRow& row = traced->row.gravity;
  if (!row.in_model || row.earth_covariance.isZero(0.0)) return;
  for (TracedEffect& effect : traced->trace.effects) {
    if (effect.id == GSensitivityEffect().id)
      AddToErrors(row.earth_covariance, AxisOf, &effect.parameters);
  }
  AddToCovariance(row.earth_covariance, AxisOf, &traced->model);
}

std::string LatitudeNeeded(const std::vector<TracedEffect>& effects) {
  const bool doubted = std::ranges::any_of(effects, [](const TracedEffect& effect) {
    return Names(effect, EarthRotationEffect().id) || effect.id == GSensitivityEffect().id;
  });
  if (!doubted) return "";
  return fmt::format(
      "The site's latitude is needed: Earth's rotation ({:.2g} deg/s) is not taken off and passes "
      "for a sensitivity to gravity, whose errors count it, and for bias, whose errors do not. Set "
      "site.latitude_deg in the stand file (site_latitude_deg in a table) and measure or trace "
      "again",
      EarthRate_deg_s());
}

}  // namespace gyrobench::calibration
