#include "report/reason.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>

namespace gyrobench::report {
namespace {

void Append(std::string& list, const std::string& separator, const std::string& text) {
  list += (list.empty() ? "" : separator) + text;
}

// 1 of "1/(deg/s)", 2 of "1/(deg/s)^2"; 0 of another unit.
int PowerOfRate(const std::string& unit) {
  const std::string one = "1/(deg/s)";
  if (unit.rfind(one, 0) != 0) return 0;
  if (unit.size() == one.size()) return 1;
  return unit[one.size()] == '^' ? std::max(0, std::atoi(unit.c_str() + one.size() + 1)) : 0;
}

}  // namespace

Reason SplitReason(const std::string& because) {
  Reason reason;
  bool after_figure = false;
  for (std::size_t begin = 0; begin < because.size();) {
    const std::size_t end = std::min(because.find(", ", begin), because.size());
    const std::string part = because.substr(begin, end - begin);
    const bool is_figure =
        !reason.kind.empty() && !part.empty() && part.front() >= '0' && part.front() <= '9';
    if (is_figure) {
      Append(reason.figures, ", ", part);
    } else {
      Append(reason.kind, after_figure ? " " : ", ", part);
    }
    after_figure = is_figure;
    begin = end + 2;
  }
  return reason;
}

double LargestRate_deg_s(const calibration::ChannelTrace& channel) {
  double largest = kMissing;
  for (const double rate : channel.curves.rate_error_by_rate_deg_s.x)
    if (std::isfinite(rate)) largest = std::fmax(largest, std::fabs(rate));
  return largest;
}

std::string ScaleAtRate(double value, const std::string& unit, double rate_deg_s) {
  const int power = PowerOfRate(unit);
  const double share = value * std::pow(rate_deg_s, power);
  if (power == 0 || !std::isfinite(share) || !(rate_deg_s > 0.0)) return "";
  const bool percent = std::fabs(share) >= 1e-4;
  return fmt::format("{:.2g} {} at {:.3g} deg/s", share * (percent ? 1e2 : 1e6),
                     percent ? "%" : "ppm", rate_deg_s);
}

}  // namespace gyrobench::report
