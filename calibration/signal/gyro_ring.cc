#include "calibration/signal/gyro_ring.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

namespace gyrobench::calibration {
namespace {

constexpr double kNever_s = std::numeric_limits<double>::infinity();
// An interval that is longer than so many of the shorter one beside it has lost a sample.
constexpr double kLost = 1.5;
// A corner seems to be at most one interval off a sample that has a share of it.
constexpr double kNoCorner = 2.0;
// The sample in which a corner is has half of its jump at least; where the rate bends all along
// each has a third.
constexpr double kCorner = 0.45;
// Of shorter intervals it is nothing whether samples are means: at 100 deg/s^2 a thousandth of a
// degree.
constexpr double kFast_s = 0.015;

}  // namespace

GyroRing::GyroRing() : points_(kSize) {}

std::int64_t GyroRing::oldest() const {
  return std::max<std::int64_t>(0, count_ - static_cast<std::int64_t>(kSize));
}

std::int64_t GyroRing::FirstNotBefore(double t_s) const {
  std::int64_t low = oldest(), high = count_;
  while (low < high) {
    const std::int64_t middle = (low + high) / 2;
    if (at(middle).t_s < t_s) {
      low = middle + 1;
    } else {
      high = middle;
    }
  }
  return low;
}

void GyroRing::Push(double t_s, const Vector3& xi, bool gap) {
  point(count_++) = {.t_s = t_s, .xi = xi, .gap = gap};
  SetChord(count_ - 1);
  // The slope at the sample before the newest is new, and with it the intervals on its both sides.
  for (std::int64_t i = std::max<std::int64_t>(1, count_ - 3); i < count_; ++i) {
    Point& end = point(i);
    end.z = at(i - 1).z;
    for (std::size_t c = 0; c < 3 && !end.gap; ++c) end.z[c] += SplineIntegral(i, c, 1.0);
    AddBetween(i);
  }
}

void GyroRing::AddBetween(std::int64_t next) {
  constexpr double kOfCorner = 1.0 / 1200.0, kStep = 1.0 / 12.0;
  Point& end = point(next);
  const Point& begin = at(next - 1);
  end.between = begin.between;
  if (end.gap || next + 1 == count_) return;
  const double tau_s = end.t_s - begin.t_s, tau4_s4 = std::pow(tau_s, 4);
  for (std::size_t c = 0; c < 3; ++c) {
    const double first = Jump(next - 1, c), last = Jump(next, c);
    end.between.corners[c] += kOfCorner * tau4_s4 * (first + last) * (first + last);
    end.between.steps[c] += kStep * tau4_s4 * std::max(0.0, -first * last);
    const double cut = first * last > 0.0 ? first * last / (2.0 * (first + last)) : 0.0;
    end.between.bends[c] +=
        tau_s * tau_s * (kStep * (at(next).slope[c] - at(next - 1).slope[c]) - cut);
  }
}

// Of the slope from one side of a sample to the other; 0 where one of them is not known.
double GyroRing::Jump(std::int64_t i, std::size_t c) const {
  return HasChordFrom(i - 1) && HasChordFrom(i) ? at(i + 1).chord[c] - at(i).chord[c] : 0.0;
}

void GyroRing::Replace(std::size_t channel, double xi) {
  point(count_ - 1).xi[channel] = xi;
  SetChord(count_ - 1);
}

double GyroRing::settled_time_s() const {
  return count_ > 2 ? at(count_ - 3).t_s : -std::numeric_limits<double>::infinity();
}

bool GyroRing::IntegralAt(double t_s, IntegralMark* mark) const {
  const std::int64_t next = FirstNotBefore(t_s);
  if (next == count_) return false;
  const Point& b = at(next);
  if (b.t_s > t_s && next == oldest()) return false;
  mark->t_s = t_s;
  mark->z = b.z;
  if (b.t_s == t_s) return true;
  const Point& a = at(next - 1);
  mark->z = a.z;  // as it stays inside a gap, which is marked as bad
  const double x = (t_s - a.t_s) / (b.t_s - a.t_s);
  for (std::size_t c = 0; c < 3 && !b.gap; ++c) mark->z[c] += SplineIntegral(next, c, x);
  return true;
}

BetweenSamples GyroRing::BetweenUpTo(double t_s) const {
  const std::int64_t after = FirstNotBefore(std::nextafter(t_s, t_s + 1.0));
  return after > oldest() ? at(after - 1).between : BetweenSamples{};
}

AsMeans GyroRing::AsMeansAt(double t_s) const {
  const std::int64_t next = FirstNotBefore(t_s);
  const double interval_s = SlowIntervalBefore(next);
  if (!(interval_s > 0.0)) return {};
  const Point& a = at(next - 1);
  const double half = 2.0 * (t_s - a.t_s) / interval_s;  // 0 to 1, and to 2 after half way
  // Of a lost sample nobody knows what its mean was.
  const bool lost = interval_s > kLost * ShortestBeside(next);
  AsMeans out;
  for (std::size_t c = 0; c < 3; ++c) {
    const double first = AsMeansAtSample(next - 1, c), last = AsMeansAtSample(next, c);
    const double sum = interval_s * (0.5 * a.xi[c] + interval_s * at(next - 1).slope[c] / 12.0);
    const double half_way = lost ? std::midpoint(first, last) : sum - SplineIntegral(next, c, 0.5);
    out[c] = half < 1.0 ? std::lerp(first, half_way, half) : std::lerp(half_way, last, half - 1.0);
  }
  return out;
}

AsMeans GyroRing::AsMeansHalfAfter(double t_s) const {
  const std::int64_t next = FirstNotBefore(t_s);
  if (!(SlowIntervalBefore(next) > 0.0)) return {};
  return AsMeansAt(t_s + 0.5 * ShortestBeside(next));
}

bool GyroRing::MeansSettledAt(double t_s) const {
  // The sample after half an interval more, and the two that its corner is seen by.
  constexpr std::int64_t kMore = 3;
  const std::int64_t next = FirstNotBefore(t_s);
  return next < count_ && (!(SlowIntervalBefore(next) > 0.0) || next + kMore < count_);
}

// 0 where there is none, where a gap is, and where samples come fast.
double GyroRing::SlowIntervalBefore(std::int64_t next) const {
  if (next == count_ || next == oldest() || at(next).gap) return 0.0;
  const double interval_s = at(next).t_s - at(next - 1).t_s;
  return interval_s < kFast_s ? 0.0 : interval_s;
}

// Of the interval before sample `next` and those on its both sides.
double GyroRing::ShortestBeside(std::int64_t next) const {
  return std::min(ShorterIntervalAt(next - 1), ShorterIntervalAt(next));
}

// Of those on both sides: no sample is lost in it.
double GyroRing::ShorterIntervalAt(std::int64_t i) const {
  const double before_s = i > oldest() ? at(i).t_s - at(i - 1).t_s : kNever_s;
  return std::min(before_s, i + 1 < count_ ? at(i + 1).t_s - at(i).t_s : kNever_s);
}

// 0 beside a gap. A corner at a part f (-1/2 to 1/2) of the interval about a sample shares its
// jump a among that and its neighbours: (1/2 - f)^2 / 2 before, (1/2 + f)^2 / 2 after. The cubic
// through the sums is then off by a tau^2 (f |f| / 4 - 3 f / 16) at the sample, and at its
// neighbours by 1 / 16 of their shares. Jumps that take each other back are no corner, but a ramp
// shorter than an interval, or noise.
double GyroRing::AsMeansAtSample(std::int64_t i, std::size_t c) const {
  if (!HasChordFrom(i - 1) || !HasChordFrom(i)) return 0.0;
  const Point &before = at(i - 1), &after = at(i + 1);
  const double tau_s = ShorterIntervalAt(i),
               slope = (after.xi[c] - before.xi[c]) / (after.t_s - before.t_s);
  const double here = Jump(i, c), jump = Jump(i - 1, c) + here + Jump(i + 1, c);
  const double f = jump != 0.0 ? (Jump(i + 1, c) - Jump(i - 1, c)) / jump : 0.0;
  double off = 0.0;
  if (std::fabs(f) < 0.5 && here / jump > kCorner)
    off = jump * f * (0.25 * std::fabs(f) - 3.0 / 16.0);
  else if (std::fabs(f) >= 0.5 && std::fabs(f) < kNoCorner)
    off = std::copysign(here / 16.0, -here * f);
  return tau_s * tau_s * (at(i).slope[c] / 12.0 - slope / 8.0 - off);
}

SampleSum GyroRing::SumUpTo(double t_s) const {
  const std::int64_t after = FirstNotBefore(std::nextafter(t_s, t_s + 1.0));
  if (after == count_ || after - 2 < oldest() || at(after).gap || at(after - 1).gap) return {};
  const Point &last = at(after - 1), &next = at(after);
  const double half_s = 0.5 * (next.t_s - last.t_s), before_s = last.t_s - at(after - 2).t_s;
  SampleSum sum{last.t_s + half_s, last.z};
  for (std::size_t c = 0; c < 3; ++c) {
    // The slopes of a spline shift its integral from one interval to the next; what they did to the
    // last one is taken back.
    sum.z[c] += half_s * last.xi[c] + before_s * before_s * at(after - 1).slope[c] / 12.0;
  }
  return sum;
}

// Of the spline from sample `next` - 1 over the part x (0..1) of the interval to `next`.
double GyroRing::SplineIntegral(std::int64_t next, std::size_t c, double x) const {
  const Point &a = at(next - 1), &b = at(next);
  const double h = b.t_s - a.t_s, ma = a.slope[c], mb = b.slope[c];
  const double x2 = x * x, x3 = x2 * x, x4 = x2 * x2;
  return h * (a.xi[c] * (x - x3 + 0.5 * x4) + b.xi[c] * (x3 - 0.5 * x4)) +
         h * h * (ma * (0.5 * x2 - 2.0 / 3.0 * x3 + 0.25 * x4) + mb * (0.25 * x4 - x3 / 3.0));
}

// Whether the slope of the straight line to the next sample is known; it is not across a gap.
bool GyroRing::HasChordFrom(std::int64_t from) const {
  return from >= oldest() && from + 1 < count_ && at(from + 1).has_chord;
}

// And the slopes on its both sides.
void GyroRing::SetChord(std::int64_t to) {
  Point& end = point(to);
  end.has_chord = to > 0 && !end.gap && end.t_s > at(to - 1).t_s;
  for (std::size_t c = 0; c < 3 && end.has_chord; ++c)
    end.chord[c] = (end.xi[c] - at(to - 1).xi[c]) / (end.t_s - at(to - 1).t_s);
  if (to > 0) SetSlope(to - 1);
  SetSlope(to);
}

// Of the spline at a sample: the harmonic mean of the slopes on both sides, the nearer one weighing
// more, which does not overshoot where the rate jumps (Fritsch and Butland 1984; no more than three
// times the smaller slope keeps a cubic monotone, Fritsch and Carlson 1980). One side's where the
// other is not known.
void GyroRing::SetSlope(std::int64_t i) {
  Point& here = point(i);
  const bool has_before = HasChordFrom(i - 1), has_after = HasChordFrom(i);
  for (std::size_t c = 0; c < 3; ++c) {
    const double before = has_before ? here.chord[c] : 0.0;
    const double after = has_after ? at(i + 1).chord[c] : 0.0;
    if (!has_before || !has_after) {
      here.slope[c] = before + after;
    } else if (!(before * after > 0.0)) {
      here.slope[c] = 0.0;
    } else {
      const double h1 = here.t_s - at(i - 1).t_s, h2 = at(i + 1).t_s - here.t_s;
      const double mean = (h1 + h2) / (h2 / before + h1 / after);
      const double limit = 3.0 * std::min(std::fabs(before), std::fabs(after));
      here.slope[c] = std::clamp(mean, -limit, limit);
    }
  }
}

}  // namespace gyrobench::calibration
