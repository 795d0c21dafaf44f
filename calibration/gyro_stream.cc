#include "calibration/gyro_stream.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <optional>

namespace gyrobench::calibration {
namespace {

constexpr std::array<const char*, 3> kChannelNames = {"gyro x", "gyro y", "gyro z"};
constexpr double kShortestInterval_s = 1e-5;
constexpr double kBinsPerLog = 36.0;  // 512 bins: 10 us to 15 s, 2.8 % each

// Gaps: within so many intervals the trapezoid still bridges what is missing.
constexpr double kBridgedIntervals = 4.5;
constexpr double kShortestGap_s = 0.05;
// A frozen sensor repeats all its channels to the last bit for so long. One channel alone may do so
// when the filter leaves less noise than a count.
constexpr double kFrozen_s = 0.3;
constexpr double kFrozenOneChannel_s = 2.0;
constexpr int kFrozenSamples = 25;

// Wild samples (see the class).
constexpr double kWildBends = 8.0;
constexpr double kWildAcceleration_deg_s2 = 5000.0;
constexpr double kNeighboursAgree = 0.25;
constexpr double kDefaultUnitsPerDeg_s = 131.0;  // of counts whose sensitivity is not known
// Beyond these a number is no measurement; squares of it would overflow.
constexpr double kLargestOutput = 1e30;
constexpr double kLatestTime_s = 1e11;

// Rotation at rest: beyond so many standard deviations of the sample at rest.
constexpr double kMotionSigmas = 8.0;
constexpr double kSearch_s = 0.3;
constexpr double kLongestOnset_s = 0.06;
// Used where the gyro does not feel the motion: covers the latency of a bus and of a filter.
constexpr double kGuard_s = 0.03;

bool SameOrBothMissing(double a, double b) { return a == b || (std::isnan(a) && std::isnan(b)); }

bool SameReading(const GyroSample& a, const GyroSample& b) {
  for (std::size_t c = 0; c < 3; ++c) {
    if (!SameOrBothMissing(a.xi[c], b.xi[c]) || !SameOrBothMissing(a.accel_g[c], b.accel_g[c])) {
      return false;
    }
  }
  return true;
}

}  // namespace

GyroStream::GyroStream() : ring_(kRing) { bad_.reserve(64); }

void GyroStream::Start(const MeasurementInfo& info) {
  info_ = info;
  to_output_ = info.gyro_unit == GyroUnit::kRadPerSecond ? 180.0 / std::numbers::pi : 1.0;
  const bool counts = info.gyro_unit == GyroUnit::kLsb;
  per_deg_s_ = counts ? info.gyro_units_per_deg_s.value_or(kDefaultUnitsPerDeg_s) : 1.0;
  digit_ = counts ? 2.0 : 0.02;
}

void GyroStream::Add(const GyroSample& sample) {
  ++samples_;
  if (!(std::fabs(sample.t_s) <= kLatestTime_s)) {
    defects_.Add("not_a_number", "time", last_time_s_);
    return;
  }
  if (samples_ > 1 && sample.t_s <= last_raw_time_s_ && count_ > 0) {
    if (sample.t_s < last_raw_time_s_) {
      defects_.Add("time_backwards", "", sample.t_s);
      return;
    }
    defects_.Add("repeated_time", "", sample.t_s);
    if (held_count_ < kHeld) held_[held_count_++] = sample;
    return;
  }
  if (held_count_ > 0) PlaceHeld(sample.t_s);
  last_raw_time_s_ = sample.t_s;
  Accept(sample.t_s, sample);
}

// Samples that carried the stamp of the one before go evenly between it and the next, and not into
// a pause that follows.
void GyroStream::PlaceHeld(double t_s) {
  const double begin_s = last_time_s_;
  double step_s = (t_s - begin_s) / static_cast<double>(held_count_ + 1);
  const double usual_s = median_interval_s();
  if (t_s - begin_s > gap_limit_s_ && usual_s < step_s) step_s = usual_s;
  for (std::size_t i = 0; i < held_count_; ++i) {
    Accept(begin_s + step_s * static_cast<double>(i + 1), held_[i]);
  }
  held_count_ = 0;
}

void GyroStream::Accept(double t_s, const GyroSample& sample) {
  Point point;
  point.t_s = t_s;
  if (count_ == 0) {
    first_time_s_ = t_s;
    last_valid_t_s_.fill(t_s);
    point.xi = Take(t_s, sample);
  } else {
    const Point& last = at(count_ - 1);
    const double interval_s = t_s - last.t_s;
    CountInterval(interval_s);
    const bool gap = interval_s > gap_limit_s_;
    if (gap) {
      defects_.Add("gap", "gyro", last.t_s);
      MarkBad(last.t_s, t_s, {true, true, true});
    }
    point.xi = Take(t_s, sample);
    if (count_ >= 3) MendNewest(t_s, point.xi);
    const double half_s = gap ? 0.0 : 0.5 * interval_s;
    for (std::size_t c = 0; c < 3; ++c)
      point.z[c] = last.z[c] + half_s * (last.xi[c] + point.xi[c]);
    if (count_ == 1 && !gap) {
      for (std::size_t c = 0; c < 3; ++c) first_slope_[c] = (point.xi[c] - last.xi[c]) / interval_s;
    }
  }
  ring_[static_cast<std::size_t>(count_) & (kRing - 1)] = point;
  ++count_;
  last_time_s_ = t_s;
  CheckFrozen(t_s, sample);
}

// The newest sample, now that the next one is there.
void GyroStream::MendNewest(double next_t_s, const Vector3& next) {
  const Point &first = at(count_ - 3), &before = at(count_ - 2), &newest = at(count_ - 1);
  const double first_s = before.t_s - first.t_s, before_s = newest.t_s - before.t_s,
               after_s = next_t_s - newest.t_s;
  if (std::max({first_s, before_s, after_s}) > gap_limit_s_) return;
  for (std::size_t c = 0; c < 3; ++c) {
    if (!info_.gyro_present[c]) continue;
    const double line = before.xi[c] + (next[c] - before.xi[c]) * before_s / (before_s + after_s);
    const double off = std::fabs(newest.xi[c] - line);
    if (bends_ >= static_cast<std::int64_t>(kBends) &&
        off > kWildAcceleration_deg_s2 * per_deg_s_ * std::max(before_s, after_s) &&
        IsWild(c, off, next[c])) {
      Bridge(c, line);
    }
    const double chord =
        first.xi[c] + (newest.xi[c] - first.xi[c]) * first_s / (first_s + before_s);
    bend_[c][static_cast<std::size_t>(bends_) % kBends] = std::fabs(before.xi[c] - chord);
  }
  ++bends_;
}

bool GyroStream::IsWild(std::size_t c, double off, double next) const {
  const double before = at(count_ - 2).xi[c];
  const double apart = std::max(std::fabs(next - before), std::fabs(before - at(count_ - 3).xi[c]));
  if (apart > kNeighboursAgree * off) return false;
  const double largest = *std::max_element(bend_[c].begin(), bend_[c].end());
  return off > kWildBends * std::max(digit_, largest);
}

// Puts the newest sample on the line.
void GyroStream::Bridge(std::size_t c, double line) {
  Point& newest = ring_[static_cast<std::size_t>(count_ - 1) & (kRing - 1)];
  const Point& before = at(count_ - 2);
  defects_.Add("gyro_outlier", kChannelNames[c], newest.t_s);
  if (std::fabs(newest.xi[c]) == extreme_[c] * to_output_) extreme_[c] = extreme_before_[c];
  newest.xi[c] = line;
  newest.z[c] = before.z[c] + 0.5 * (newest.t_s - before.t_s) * (before.xi[c] + line);
}

// The values of the channels in the output's unit; a missing one is held from before.
Vector3 GyroStream::Take(double t_s, const GyroSample& sample) {
  Vector3 out = {};
  for (std::size_t c = 0; c < 3; ++c) {
    if (!info_.gyro_present[c]) continue;
    const double value = sample.xi[c] * to_output_;
    if (!(std::fabs(value) <= kLargestOutput)) {
      defects_.Add("not_a_number", kChannelNames[c], t_s);
      out[c] = count_ > 0 ? at(count_ - 1).xi[c] : 0.0;
      std::array<bool, 3> channels = {};
      channels[c] = true;
      if (++missing_[c] > 2 || valid_samples_[c] == 0) MarkBad(last_valid_t_s_[c], t_s, channels);
      continue;
    }
    if (missing_[c] > 2) {
      std::array<bool, 3> channels = {};
      channels[c] = true;
      MarkBad(last_valid_t_s_[c], t_s, channels);
    }
    missing_[c] = 0;
    last_valid_t_s_[c] = t_s;
    ++valid_samples_[c];
    out[c] = value;
    CheckSaturation(t_s, c, sample.xi[c]);
  }
  return out;
}

void GyroStream::CheckFrozen(double t_s, const GyroSample& sample) {
  if (frozen_samples_ == 0 || !SameReading(frozen_, sample)) {
    frozen_ = sample;
    frozen_since_s_ = t_s;
    frozen_samples_ = 1;
    return;
  }
  ++frozen_samples_;
  int channels = 0;
  for (std::size_t c = 0; c < 3; ++c) {
    channels += (std::isfinite(sample.xi[c]) ? 1 : 0) + (std::isfinite(sample.accel_g[c]) ? 1 : 0);
  }
  if (channels == 0 || frozen_samples_ < kFrozenSamples) return;
  if (t_s - frozen_since_s_ < (channels > 1 ? kFrozen_s : kFrozenOneChannel_s)) return;
  // Counted in samples; the first time it is seen brings those that led to it.
  const bool first = (bad_.empty() || bad_.back().end_s < frozen_since_s_);
  defects_.Add("frozen", "gyro", frozen_since_s_, first ? frozen_samples_ : 1);
  MarkBad(frozen_since_s_, t_s, {true, true, true});
}

// At the limits of 16 bits; for a sensor that scales by itself, its largest value over and over.
void GyroStream::CheckSaturation(double t_s, std::size_t c, double value) {
  const double size = std::fabs(value);
  std::array<bool, 3> channels = {};
  channels[c] = true;
  const double interval_s = count_ > 0 ? t_s - last_time_s_ : 0.0;
  if (info_.gyro_unit == GyroUnit::kLsb) {
    if (size < 32767.0) return;
    defects_.Add("saturation", kChannelNames[c], t_s);
    MarkBad(t_s - interval_s, t_s + interval_s, channels);
    return;
  }
  if (size * to_output_ < 100.0 || size < extreme_[c]) {
    at_extreme_[c] = 0;
    return;
  }
  if (size > extreme_[c]) {
    extreme_before_[c] = extreme_[c];
    extreme_[c] = size;
    at_extreme_[c] = 1;
    extreme_since_s_[c] = t_s;
    return;
  }
  if (at_extreme_[c]++ == 0) extreme_since_s_[c] = t_s;
  if (at_extreme_[c] < 4) return;
  defects_.Add("saturation", kChannelNames[c], extreme_since_s_[c], at_extreme_[c] == 4 ? 4 : 1);
  MarkBad(extreme_since_s_[c] - interval_s, t_s + interval_s, channels);
}

void GyroStream::MarkBad(double begin_s, double end_s, std::array<bool, 3> channels) {
  // Neighbours within a node's distance become one, so that bad data cannot fill the memory.
  for (std::size_t back = 1; back <= 3 && back <= bad_.size(); ++back) {
    BadStretch& last = bad_[bad_.size() - back];
    if (last.channel != channels || begin_s > last.end_s + 0.2) continue;
    last.begin_s = std::min(last.begin_s, begin_s);
    last.end_s = std::max(last.end_s, end_s);
    return;
  }
  bad_.push_back(BadStretch{begin_s, end_s, channels});
}

void GyroStream::CountInterval(double interval_s) {
  // Most intervals fall where the last one did: no logarithm for them.
  if (!(interval_s >= bin_low_s_ && interval_s < bin_high_s_)) {
    const double position = std::log(interval_s / kShortestInterval_s) * kBinsPerLog;
    bin_ = static_cast<std::size_t>(std::clamp(position, 0.0, static_cast<double>(kBins - 1)));
    bin_low_s_ = kShortestInterval_s * std::exp(static_cast<double>(bin_) / kBinsPerLog);
    bin_high_s_ = kShortestInterval_s * std::exp(static_cast<double>(bin_ + 1) / kBinsPerLog);
  }
  ++interval_count_[bin_];
  interval_sum_[bin_] += interval_s;
  if (count_ == 8 || (count_ & 1023) == 0) {
    gap_limit_s_ = std::max(kShortestGap_s, kBridgedIntervals * median_interval_s());
  }
}

double GyroStream::median_interval_s() const {
  std::int64_t total = 0;
  for (const std::int64_t n : interval_count_) total += n;
  std::int64_t below = 0;
  for (std::size_t bin = 0; bin < kBins; ++bin) {
    below += interval_count_[bin];
    if (total > 0 && 2 * below >= total) {
      return interval_sum_[bin] / static_cast<double>(interval_count_[bin]);
    }
  }
  return kMissing;
}

std::int64_t GyroStream::oldest() const {
  return std::max<std::int64_t>(0, count_ - static_cast<std::int64_t>(kRing));
}

std::int64_t GyroStream::FirstNotBefore(double t_s) const {
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

bool GyroStream::IntegralAt(double t_s, IntegralMark* mark) const {
  const std::int64_t next = FirstNotBefore(t_s);
  if (next == count_) return false;
  const Point& b = at(next);
  if (b.t_s > t_s && next == oldest()) return false;
  mark->t_s = t_s;
  mark->z = b.z;
  if (next == oldest()) return true;
  const Point& a = at(next - 1);
  const double whole_s = b.t_s - a.t_s, part_s = t_s - a.t_s;
  if (whole_s > gap_limit_s_) {
    mark->z = a.z;  // inside a gap, which is marked as bad
    return true;
  }
  for (std::size_t c = 0; c < 3; ++c) mark->z[c] = SplineIntegral(next, c, part_s / whole_s);
  return true;
}

// The trapezoid rule cuts the corners of a rate that bends: by interval^2 / 12 times the angular
// acceleration, 0.002 deg at 50 Hz and 60 deg/s2. Summed up, the integral of a monotone cubic
// spline through the samples (Fritsch and Butland 1984) differs from it by that term at both ends
// alone.
double GyroStream::SplineIntegral(std::int64_t next, std::size_t c, double x) const {
  const Point &a = at(next - 1), &b = at(next);
  const double h = b.t_s - a.t_s, ma = SlopeAt(next - 1, c), mb = SlopeAt(next, c);
  const double x2 = x * x, x3 = x2 * x, x4 = x2 * x2;
  return a.z[c] + h * h / 12.0 * (first_slope_[c] - ma) +
         h * (a.xi[c] * (x - x3 + 0.5 * x4) + b.xi[c] * (x3 - 0.5 * x4)) +
         h * h * (ma * (0.5 * x2 - 2.0 / 3.0 * x3 + 0.25 * x4) + mb * (0.25 * x4 - x3 / 3.0));
}

// Of the spline at a sample: the harmonic mean of the slopes on both sides, which does not
// overshoot where the rate jumps; one side's where the other is not known or behind a gap.
double GyroStream::SlopeAt(std::int64_t i, std::size_t c) const {
  auto slope = [&](std::int64_t from) -> std::optional<double> {
    if (from < oldest() || from + 1 >= count_) return std::nullopt;
    const double h = at(from + 1).t_s - at(from).t_s;
    if (h > gap_limit_s_) return std::nullopt;
    return (at(from + 1).xi[c] - at(from).xi[c]) / h;
  };
  const std::optional<double> before = slope(i - 1), after = slope(i);
  if (!before || !after) return before.value_or(after.value_or(0.0));
  return *before * *after > 0.0 ? 2.0 * *before * *after / (*before + *after) : 0.0;
}

GyroStream::Quiet GyroStream::QuietBetween(double begin_s, double end_s) const {
  Quiet quiet;
  Vector3 sum = {}, square = {};
  const std::int64_t begin = FirstNotBefore(begin_s), end = FirstNotBefore(end_s);
  for (std::int64_t i = begin; i < end; ++i) {
    for (std::size_t c = 0; c < 3; ++c) sum[c] += at(i).xi[c];
  }
  quiet.samples = static_cast<int>(end - begin);
  const double n = std::max(1.0, static_cast<double>(quiet.samples));
  for (std::size_t c = 0; c < 3; ++c) quiet.mean[c] = sum[c] / n;
  for (std::int64_t i = begin; i < end; ++i) {
    for (std::size_t c = 0; c < 3; ++c) square[c] += std::pow(at(i).xi[c] - quiet.mean[c], 2);
  }
  for (std::size_t c = 0; c < 3; ++c) {
    // A sensor without noise of its own still shows its last digit.
    const double digit = info_.gyro_unit == GyroUnit::kLsb ? 0.3 : 0.01;
    quiet.threshold[c] =
        kMotionSigmas * std::max(digit, std::sqrt(square[c] / std::max(1.0, n - 1)));
  }
  return quiet;
}

// The largest deviation of a sample among the channels, in units of the channel's threshold.
double GyroStream::Deviation(const Quiet& quiet, std::int64_t index) const {
  double largest = 0.0;
  for (std::size_t c = 0; c < 3; ++c) {
    if (!info_.gyro_present[c]) continue;
    largest = std::max(largest, std::fabs(at(index).xi[c] - quiet.mean[c]) / quiet.threshold[c]);
  }
  return largest;
}

double GyroStream::RestBegin(double coarse_s) const {
  const Quiet quiet = QuietBetween(coarse_s + 0.2, coarse_s + 0.45);
  if (quiet.samples < 8) return coarse_s + kGuard_s;
  const std::int64_t first = FirstNotBefore(coarse_s - kSearch_s);
  for (std::int64_t i = FirstNotBefore(coarse_s + 0.2); i > first; --i) {
    const double here = Deviation(quiet, i);
    if (here <= 1.0 || i + 1 >= count_) continue;
    const double interval_s = at(i).t_s - at(i - 1).t_s;
    const double before = Deviation(quiet, i - 1);
    // The rate falls linearly to zero while the table brakes.
    const double onset_s = before > here ? here * interval_s / (before - here) : 0.0;
    return std::max(at(i + 1).t_s, at(i).t_s + std::min(onset_s, kLongestOnset_s)) + interval_s;
  }
  return coarse_s + kGuard_s;
}

double GyroStream::RestEnd(double coarse_s, double moving_s) const {
  const Quiet quiet = QuietBetween(coarse_s - 0.5, coarse_s - 0.15);
  if (quiet.samples < 8) return coarse_s - kGuard_s;
  const std::int64_t end = FirstNotBefore(moving_s + 0.1);
  for (std::int64_t i = std::max(oldest() + 1, FirstNotBefore(coarse_s - 0.15)); i < end; ++i) {
    const double here = Deviation(quiet, i);
    if (here <= 1.0 || i + 1 >= count_) continue;
    const double interval_s = at(i + 1).t_s - at(i).t_s;
    const double after = Deviation(quiet, i + 1);
    const double onset_s = after > here ? here * interval_s / (after - here) : 0.0;
    return std::min(at(i - 1).t_s, at(i).t_s - std::min(onset_s, kLongestOnset_s)) - interval_s;
  }
  return coarse_s - kGuard_s;
}

}  // namespace gyrobench::calibration
