#include "calibration/state/gaps.h"

#include <cmath>
#include <cstddef>
#include <limits>

namespace gyrobench::calibration {

void BridgeGaps(const std::vector<double>& t_s, double shortest_s, std::vector<double>* value) {
  std::vector<double>& x = *value;
  std::size_t a = x.size();  // the last known
  for (std::size_t b = 0; b < x.size(); ++b) {
    if (!std::isfinite(x[b])) continue;
    const double length_s = a < b ? t_s[b] - t_s[a] : 0.0;
    if (length_s > shortest_s && length_s <= kLongestBridge_s) {
      for (std::size_t k = a + 1; k < b; ++k)
        x[k] = x[a] + (x[b] - x[a]) * (t_s[k] - t_s[a]) / length_s;
    }
    a = b;
  }
}

std::vector<bool> TellableTimes(const std::vector<double>& t_s, const std::vector<double>& value) {
  constexpr double kNever = std::numeric_limits<double>::infinity();
  std::vector<double> since_s(value.size()), until_s(value.size());
  double known_s = -kNever;
  for (std::size_t k = 0; k < value.size(); ++k) {
    if (std::isfinite(value[k])) known_s = t_s[k];
    since_s[k] = t_s[k] - known_s;
  }
  known_s = kNever;
  for (std::size_t k = value.size(); k-- > 0;) {
    if (std::isfinite(value[k])) known_s = t_s[k];
    until_s[k] = known_s - t_s[k];
  }
  std::vector<bool> out(value.size());
  for (std::size_t k = 0; k < value.size(); ++k) {
    out[k] = since_s[k] + until_s[k] <= kLongestBridge_s || since_s[k] <= kNearKnown_s ||
             until_s[k] <= kNearKnown_s;
  }
  return out;
}

double TellableShare(const std::vector<double>& t_s, const std::vector<bool>& tellable) {
  double told_s = 0.0;
  for (std::size_t k = 1; k < t_s.size(); ++k)
    told_s += tellable[k] && tellable[k - 1] ? t_s[k] - t_s[k - 1] : 0.0;
  return t_s.size() < 2 ? 0.0 : told_s / (t_s.back() - t_s.front());
}

}  // namespace gyrobench::calibration
