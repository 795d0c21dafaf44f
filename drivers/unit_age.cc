#include "drivers/unit_age.h"

#include <algorithm>
#include <cmath>

namespace gyrobench::drivers {
namespace {

// A sensor's own clock, which paces its samples, is off by this at most; and some get lost.
constexpr double kRateTolerance = 0.03;
// A unit does not sample from its first moment.
constexpr double kStart_s = 2.0;

}  // namespace

std::optional<double> SecondsSinceBoot(double tick_s, double tick_wrap_s,
                                       std::int64_t samples_since_boot, double sample_rate_hz) {
  if (!(sample_rate_hz > 0.0) || !(tick_wrap_s > 0.0)) return std::nullopt;
  const double sampled_s = static_cast<double>(samples_since_boot) / sample_rate_hz;
  const double wraps = std::max(0.0, std::round((sampled_s - tick_s) / tick_wrap_s));
  const double up_s = tick_s + wraps * tick_wrap_s;
  const double tolerance_s = kStart_s + kRateTolerance * up_s;
  if (std::fabs(sampled_s - up_s) > tolerance_s || tolerance_s > 0.5 * tick_wrap_s)
    return std::nullopt;
  return up_s;
}

}  // namespace gyrobench::drivers
