#include "calibration/trace/smooth.h"

#include <cmath>
#include <cstddef>
#include <limits>

namespace gyrobench::calibration {
namespace {

constexpr double kNone = std::numeric_limits<double>::quiet_NaN();

// Sums of powers, so that any window is a difference of two.
struct Sums {
  double n = 0, t = 0, y = 0, tt = 0, ty = 0, yy = 0;
};
Sums operator-(const Sums& a, const Sums& b) {
  return {a.n - b.n, a.t - b.t, a.y - b.y, a.tt - b.tt, a.ty - b.ty, a.yy - b.yy};
}

struct Line {
  double value = kNone, rate = kNone, variance = kNone;
};

Line FitLine(const Sums& sums, double at) {
  Line line;
  if (sums.n < 1) return line;
  const double t = sums.t / sums.n, y = sums.y / sums.n;
  const double tt = sums.tt / sums.n - t * t, ty = sums.ty / sums.n - t * y;
  const double slope = sums.n > 2 && tt > 1e-12 ? ty / tt : 0.0;
  line.rate = slope;
  line.value = y + slope * (at - t);
  if (sums.n > 2)
    line.variance = std::fmax(0.0, sums.yy / sums.n - y * y - slope * ty) * sums.n / (sums.n - 2);
  return line;
}

// A side must fit so much better than both together to be believed.
constexpr double kClearlyBetter = 0.6;

}  // namespace

Smoothed SmoothByLines(const std::vector<double>& t_s, const std::vector<double>& value,
                       double half_window_s) {
  const std::size_t n = t_s.size();
  Smoothed out{std::vector<double>(n, kNone), std::vector<double>(n, kNone)};
  double origin = 0.0;
  for (std::size_t i = 0; i < n; ++i) {
    if (std::isfinite(value[i])) {
      origin = value[i];
      break;
    }
  }
  // Relative to the first value and to time zero of a moving origin the sums keep their digits for
  // hours of data: T within 100, t within 1e5 s.
  std::vector<Sums> sums(n + 1);
  for (std::size_t i = 0; i < n; ++i) {
    sums[i + 1] = sums[i];
    if (!std::isfinite(value[i])) continue;
    const double t = t_s[i] - t_s[0], y = value[i] - origin;
    Sums& s = sums[i + 1];
    s.n += 1;
    s.t += t;
    s.y += y;
    s.tt += t * t;
    s.ty += t * y;
    s.yy += y * y;
  }
  std::size_t first = 0, last = 0;
  for (std::size_t i = 0; i < n; ++i) {
    while (t_s[i] - t_s[first] > half_window_s) ++first;
    while (last < n && t_s[last] - t_s[i] <= half_window_s) ++last;
    const double at = t_s[i] - t_s[0];
    Line line = FitLine(sums[last] - sums[first], at);
    const Line before = FitLine(sums[i + 1] - sums[first], at);
    const Line after = FitLine(sums[last] - sums[i], at);
    const bool full = i - first > 8 && last - i > 8;
    const Line& side = before.variance < after.variance ? before : after;
    if (full && side.variance < kClearlyBetter * line.variance) line = side;
    out.value[i] = line.value + origin;
    out.rate[i] = line.rate;
  }
  return out;
}

}  // namespace gyrobench::calibration
