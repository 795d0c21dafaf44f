#include "calibration/trace/reference_angle_error.h"

#include <algorithm>
#include <cmath>

#include "calibration/state/state_history.h"

namespace gyrobench::calibration {

// Delays are straight lines of the time: their sum is largest where a measurement begins or ends.
double LongestDelay_s(std::span<const StateHistory> histories, const std::vector<Delay>& delays) {
  double longest_s = 0.0;
  if (delays.empty()) return longest_s;
  for (const StateHistory& history : histories) {
    if (history.nodes.empty()) continue;
    for (const double t_s : {history.nodes.front().t_s, history.nodes.back().t_s})
      longest_s = std::max(longest_s, std::fabs(TotalDelay_s(delays, t_s)));
  }
  return longest_s;
}

}  // namespace gyrobench::calibration
