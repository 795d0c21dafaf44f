#include "base/away_from_drift.h"

#include <cmath>

namespace gyrobench {

std::vector<bool> AwayFromDrift(const std::vector<double>& values, double usual,
                                const DriftLimits& limits) {
  std::vector<bool> away(values.size(), false);
  if (values.empty()) return away;
  std::size_t anchor = 0;
  for (std::size_t k = 0; k < values.size(); ++k) {
    if (std::fabs(values[k] - usual) < std::fabs(values[anchor] - usual)) anchor = k;
  }
  double drift = values[anchor];
  auto look = [&](std::size_t k) {
    away[k] = std::fabs(values[k] - drift) > limits.most;
    if (!away[k]) drift += limits.share * (values[k] - drift);
  };
  for (std::size_t k = anchor; k < values.size(); ++k) look(k);
  drift = values[anchor];
  for (std::size_t k = anchor; k-- > 0;) look(k);
  return away;
}

}  // namespace gyrobench
