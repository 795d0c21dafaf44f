#include "calibration/state/smooth.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>

namespace gyrobench::calibration {
namespace {

constexpr double kFullSide = 8;  // values
constexpr double kNone = std::numeric_limits<double>::quiet_NaN();

// Sums of powers of the time from the middle of a window, and of these with the values.
struct Sums {
  double n = 0, t = 0, tt = 0, ttt = 0, tttt = 0, y = 0, ty = 0, tty = 0, yy = 0;
  void Add(double t1, double value) {
    const double t2 = t1 * t1;
    n += 1;
    t += t1;
    tt += t2;
    ttt += t2 * t1;
    tttt += t2 * t2;
    y += value;
    ty += t1 * value;
    tty += t2 * value;
    yy += value * value;
  }
};
Sums operator+(const Sums& a, const Sums& b) {
  return {a.n + b.n, a.t + b.t,   a.tt + b.tt,   a.ttt + b.ttt, a.tttt + b.tttt,
          a.y + b.y, a.ty + b.ty, a.tty + b.tty, a.yy + b.yy};
}

// Value and rate in the middle of the window, and the variance about the curve.
struct Curve {
  double value = kNone, rate = kNone, variance = kNone;
};

Curve FitLine(const Sums& sums) {
  Curve line;
  if (sums.n < 1) return line;
  const double t = sums.t / sums.n, y = sums.y / sums.n;
  const double tt = sums.tt / sums.n - t * t, ty = sums.ty / sums.n - t * y;
  line.rate = sums.n > 2 && tt > 1e-12 ? ty / tt : 0.0;
  line.value = y - line.rate * t;
  if (sums.n > 2) {
    line.variance =
        std::fmax(0.0, sums.yy / sums.n - y * y - line.rate * ty) * sums.n / (sums.n - 2);
  }
  return line;
}

Curve FitParabola(const Sums& sums) {
  Curve curve;
  if (sums.n < 6) return curve;
  const double scale = std::sqrt(sums.tt / sums.n);  // of the time
  const double s2 = scale * scale;
  Eigen::Matrix3d gram;
  gram << sums.n, sums.t / scale, sums.tt / s2,               //
      sums.t / scale, sums.tt / s2, sums.ttt / (s2 * scale),  //
      sums.tt / s2, sums.ttt / (s2 * scale), sums.tttt / (s2 * s2);
  const Eigen::Vector3d right(sums.y, sums.ty / scale, sums.tty / s2);
  const Eigen::Vector3d c = gram.ldlt().solve(right);
  curve.value = c(0);
  curve.rate = c(1) / scale;
  curve.variance = std::fmax(0.0, sums.yy - c.dot(right)) / (sums.n - 3);
  return curve;
}

// A bend in the window must leave so much less than a smooth curve does to be believed, and a
// smooth curve than a line.
constexpr double kClearlyBetter = 0.6, kBetter = 0.9;
// Variances that differ by less than half of this share are alike.
constexpr double kAlike = 0.6;

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
  std::size_t first = 0, last = 0;
  for (std::size_t i = 0; i < n; ++i) {
    while (t_s[i] - t_s[first] > half_window_s) ++first;
    while (last < n && t_s[last] - t_s[i] <= half_window_s) ++last;
    Sums before, here, after;
    for (std::size_t k = first; k < last; ++k) {
      if (!std::isfinite(value[k])) continue;
      (k < i ? before : (k == i ? here : after)).Add(t_s[k] - t_s[i], value[k] - origin);
    }
    Curve best = FitLine(before + here + after);
    if (before.n >= kFullSide && after.n >= kFullSide) {
      const Curve parabola = FitParabola(before + here + after);
      if (parabola.variance < kBetter * best.variance) best = parabola;
      const Curve left = FitLine(before + here), right = FitLine(here + after);
      const double least = std::fmin(left.variance, right.variance);
      if (least < kClearlyBetter * best.variance) {
        // At the bend itself neither side is better, and the truth lies between.
        const double to_right = std::clamp(
            0.5 + (left.variance - right.variance) / (least * kAlike + 1e-300), 0.0, 1.0);
        best.value = (1.0 - to_right) * left.value + to_right * right.value;
        best.rate = (1.0 - to_right) * left.rate + to_right * right.rate;
      }
    }
    out.value[i] = best.value + origin;
    out.rate[i] = best.rate;
  }
  return out;
}

}  // namespace gyrobench::calibration
