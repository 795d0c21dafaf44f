#include "calibration/state/slow_quantity.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>

namespace gyrobench::calibration {
namespace {

constexpr std::size_t kFullSide = 8;  // values
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

// A smooth curve must leave so much less than a line does to be believed.
constexpr double kBetter = 0.9;
// A bend, at the best of all places, must gain so much of -2 log L: about 8 by chance.
constexpr double kClearGain = 20.0;

// Of two straight lines that meet `bend_s` from the middle of the window; `beyond`: of the values
// after that.
Curve FitBent(const Sums& all, const Sums& beyond, double bend_s) {
  const double scale = std::sqrt(all.tt / all.n);  // of the time
  const double s2 = scale * scale;
  const double h = (beyond.t - bend_s * beyond.n) / scale;
  const double th = (beyond.tt - bend_s * beyond.t) / s2;
  const double hh = (beyond.tt - 2.0 * bend_s * beyond.t + bend_s * bend_s * beyond.n) / s2;
  Eigen::Matrix3d gram;
  gram << all.n, all.t / scale, h,     //
      all.t / scale, all.tt / s2, th,  //
      h, th, hh;
  const Eigen::Vector3d right(all.y, all.ty / scale, (beyond.ty - bend_s * beyond.y) / scale);
  const Eigen::Vector3d c = gram.ldlt().solve(right);
  Curve curve;
  curve.value = c(0) + c(2) * std::fmax(0.0, -bend_s) / scale;
  curve.rate = (c(1) + c(2) * (bend_s < 0.0 ? 1.0 : (bend_s > 0.0 ? 0.0 : 0.5))) / scale;
  curve.variance = std::fmax(0.0, all.yy - c.dot(right)) / (all.n - 4);
  return curve;
}

// By how much a bend lowers the sum of squares that a line leaves.
double GainOfBend(const Sums& all, const Sums& beyond, double bend_s) {
  const double h = beyond.t - bend_s * beyond.n;
  const double hh = beyond.tt - 2.0 * bend_s * beyond.t + bend_s * bend_s * beyond.n;
  const double hy = beyond.ty - bend_s * beyond.y, th = beyond.tt - bend_s * beyond.t;
  const double tt = all.tt - all.t * all.t / all.n, ty = all.ty - all.t * all.y / all.n;
  const double th_off = th - all.t * h / all.n;
  const double left = hh - h * h / all.n - th_off * th_off / tt;
  const double product = hy - all.y * h / all.n - th_off * ty / tt;
  return left > 1e-9 * hh ? product * product / left : 0.0;
}

// A place for a bend, and what follows it.
struct Bend {
  Sums beyond;
  double at_s = 0.0;
  std::size_t index = 0;
  double gain = 0.0;

  void Try(const Sums& all, Bend other) {
    other.gain = GainOfBend(all, other.beyond, other.at_s);
    if (other.gain > gain) *this = other;
  }
};

// What lies within a window, times from its middle.
class Window {
 public:
  void Clear() {
    t_s_.clear();
    value_.clear();
    differences_ = 0.0;
  }
  void Add(double t_s, double value) {
    if (!value_.empty()) differences_ += (value - value_.back()) * (value - value_.back());
    t_s_.push_back(t_s);
    value_.push_back(value);
  }

  // Two straight lines in the place of a curve about which the values have such a variance, where
  // they clearly fit better.
  Curve BentFor(const Curve& curve, const Sums& all) const {
    const double n = all.n, step = curve.rate * (t_s_.back() - t_s_.front()) / (n - 1);
    const double noise = std::fmax(0.0, 0.5 * (differences_ / (n - 1) - step * step));
    // Noise alone cannot be worth it.
    if (!(n * std::log(curve.variance / (0.8 * noise)) > kClearGain)) return curve;
    const Curve bent = BestBent(all);
    // Values that are alike for long, as rounding makes them, tell less than so many.
    const double tell = n * std::fmin(1.0, noise / bent.variance);
    return tell * std::log(curve.variance / bent.variance) > kClearGain ? bent : curve;
  }

 private:
  // Where a bend gains most: at one of the values first, then between it and its neighbours.
  Curve BestBent(const Sums& all) const {
    Sums beyond;
    Bend best;
    for (std::size_t k = t_s_.size(); k-- > kFullSide;) {
      if (t_s_.size() - k > kFullSide) best.Try(all, {beyond, t_s_[k], k});
      beyond.Add(t_s_[k], value_[k]);
    }
    if (!(best.gain > 0.0)) return {};
    const Bend at_value = best;
    Sums with_it = at_value.beyond;
    with_it.Add(at_value.at_s, value_[at_value.index]);
    constexpr int kParts = 8;
    for (int part = 1; part < kParts; ++part) {
      const double share = static_cast<double>(part) / kParts;
      const double before_s = std::lerp(t_s_[at_value.index - 1], at_value.at_s, share);
      const double after_s = std::lerp(at_value.at_s, t_s_[at_value.index + 1], share);
      best.Try(all, {with_it, before_s, at_value.index});
      best.Try(all, {at_value.beyond, after_s, at_value.index});
    }
    return FitBent(all, best.beyond, best.at_s);
  }

  std::vector<double> t_s_, value_;
  double differences_ = 0.0;  // sum of the squares of those from value to value
};

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
  Window window;
  for (std::size_t i = 0; i < n; ++i) {
    while (t_s[i] - t_s[first] > half_window_s) ++first;
    while (last < n && t_s[last] - t_s[i] <= half_window_s) ++last;
    Sums before, here, after;
    window.Clear();
    for (std::size_t k = first; k < last; ++k) {
      if (!std::isfinite(value[k])) continue;
      (k < i ? before : (k == i ? here : after)).Add(t_s[k] - t_s[i], value[k] - origin);
      window.Add(t_s[k] - t_s[i], value[k] - origin);
    }
    const Sums all = before + here + after;
    Curve best = FitLine(all);
    if (before.n >= kFullSide && after.n >= kFullSide) {
      const Curve parabola = FitParabola(all);
      if (parabola.variance < kBetter * best.variance) best = parabola;
      best = window.BentFor(best, all);
    }
    out.value[i] = best.value + origin;
    out.rate[i] = best.rate;
  }
  return out;
}

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
