#include "calibration/effects/catalogue/turned_on.h"

#include <algorithm>
#include <cmath>

#include "calibration/signal/columns.h"

namespace gyrobench::calibration {

double TurnedOn(const TrackPoint& point, std::size_t channel, double tau_s) {
  if (point.turned_near_deg == nullptr) return kMissing;
  constexpr int kReach = static_cast<int>(kNear_s.size()) / 2;  // steps either way
  const Near& near = *point.turned_near_deg;
  auto at = [&](int step) {
    if (step == 0) return 0.0;
    return near[static_cast<std::size_t>(step < 0 ? step + kReach : step + kReach - 1)][channel];
  };
  const double u = tau_s / kNearStep_s;
  if (std::fabs(u) > kReach) {
    const int edge = u > 0 ? kReach : -kReach, inner = u > 0 ? kReach - 1 : 1 - kReach;
    return at(edge) + (u - edge) * (at(edge) - at(inner)) * (edge > 0 ? 1.0 : -1.0);
  }
  const int first = std::clamp(static_cast<int>(std::floor(u)) - 1, -kReach, kReach - 3);
  const double x = u - first;  // 0..3
  return -(x - 1) * (x - 2) * (x - 3) / 6.0 * at(first) +
         x * (x - 2) * (x - 3) / 2.0 * at(first + 1) - x * (x - 1) * (x - 3) / 2.0 * at(first + 2) +
         x * (x - 1) * (x - 2) / 6.0 * at(first + 3);
}

}  // namespace gyrobench::calibration
