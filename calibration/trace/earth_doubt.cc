#include <fmt/format.h>

#include <algorithm>

#include "calibration/effects/effect.h"
#include "calibration/trace/report_parts.h"
#include "kinematics/stand_frame.h"

namespace gyrobench::calibration {
namespace {

// At the pole all of it is along z.
double Earth_deg_s() { return kinematics::EarthRate(90.0, 0.0)[2]; }

bool Names(const TracedEffect& effect, const std::string& id) {
  return effect.id == id || std::ranges::find(effect.rivals, id) != effect.rivals.end();
}

}  // namespace

std::string LatitudeNeeded(const std::vector<TracedEffect>& effects) {
  const bool doubted = std::ranges::any_of(effects, [](const TracedEffect& effect) {
    return Names(effect, EarthRotationEffect().id) || effect.id == GSensitivityEffect().id;
  });
  if (!doubted) return "";
  return fmt::format(
      "The site's latitude is needed: Earth's rotation ({:.2g} deg/s) is not taken off and passes "
      "for a sensitivity to gravity, whose numbers may be off by as much beside their errors. Set "
      "site.latitude_deg in the stand file (site_latitude_deg in "
      "a table) and measure or trace again",
      Earth_deg_s());
}

}  // namespace gyrobench::calibration
