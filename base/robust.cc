#include "base/robust.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace gyrobench {

double Median(std::vector<double> values) {
  if (values.empty()) return std::numeric_limits<double>::quiet_NaN();
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

std::vector<double> Crowd(std::vector<double> values, double width) {
  std::ranges::sort(values);
  std::size_t begin = 0, most_begin = 0, most_end = 0;
  for (std::size_t end = 1; end <= values.size(); ++end) {
    while (values[end - 1] - values[begin] > width) ++begin;
    if (end - begin <= most_end - most_begin) continue;
    most_begin = begin;
    most_end = end;
  }
  return {values.begin() + static_cast<std::ptrdiff_t>(most_begin),
          values.begin() + static_cast<std::ptrdiff_t>(most_end)};
}

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
