#include "calibration/signal/gyro_stream.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "base/geometry.h"
#include "calibration/signal/output_unit.h"

namespace gyrobench::calibration {
namespace {

constexpr std::array<const char*, 3> kChannelNames = {"gyro x", "gyro y", "gyro z"};
constexpr double kShortestInterval_s = 1e-5;
constexpr double kBinsPerLog = 36.0;  // 512 bins: 10 us to 15 s, 2.8 % each

// Gaps: within so many intervals the trapezoid still bridges what is missing.
constexpr double kBridgedIntervals = 4.5;
constexpr double kShortestGap_s = 0.05;

// Wild samples (see the class).
constexpr double kWildBends = 8.0, kSmallWildBends = 40.0, kWildInQuietBends = 12.0;
constexpr double kSmallWild_deg_s2 = 300.0, kLoneWild_deg_s2 = 100.0;
constexpr double kNeighboursAgree = 0.25, kQuietBends = 2.0;
constexpr double kSmallWildApart_s = 5.0;
constexpr double kMisalignment = 0.01;
// Where fewer than kBends are known yet, so many must be for a large wild sample to be told. No
// motion of the measured data, each begun again at every seventh sample, is taken for one (test
// HasNoWildSampleWhereverItBegins).
constexpr std::int64_t kBendsForLargeWild = 8;
// Beyond these a number is no measurement; squares of it would overflow.
constexpr double kLargestOutput = 1e30;
constexpr double kLatestTime_s = 1e11;

}  // namespace

GyroStream::GyroStream() { bad_.reserve(64); }

void GyroStream::Start(const MeasurementInfo& info) {
  info_ = info;
  to_output_ = info.gyro_unit == RateUnit::kRadPerSecond ? kDegPerRad : 1.0;
  const bool counts = info.gyro_unit == RateUnit::kLsb;
  per_deg_s_ = counts ? RoughUnitsPerDeg_s(info) : 1.0;
  digit_ = counts ? 2.0 : 0.02;
  saturation_.Start(info);
  freeze_.Start(info);
  wrapped_.Start(info);
}

void GyroStream::Add(const GyroSample& sample) {
  ++samples_;
  fingerprints_.Add(sample.xi);
  if (!(std::fabs(sample.t_s) <= kLatestTime_s)) {
    defects_.Add("not_a_number", "time", last_time_s_);
    return;
  }
  if (samples_ > 1 && sample.t_s <= last_raw_time_s_ && started()) {
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
  Enter(sample.t_s, sample);
}

// Samples that carried the stamp of the one before go evenly between it and the next, and not into
// a pause that follows.
void GyroStream::PlaceHeld(double t_s) {
  const double begin_s = last_raw_time_s_;
  double step_s = (t_s - begin_s) / static_cast<double>(held_count_ + 1);
  const double usual_s = median_interval_s();
  if (t_s - begin_s > gap_limit_s_ && usual_s < step_s) step_s = usual_s;
  for (std::size_t i = 0; i < held_count_; ++i) {
    Enter(begin_s + step_s * static_cast<double>(i + 1), held_[i]);
  }
  held_count_ = 0;
}

void GyroStream::Enter(double t_s, const GyroSample& sample) {
  GyroSample known = sample;
  for (std::size_t c = 0; c < 3; ++c) {
    if (!info_.gyro_present[c] || std::fabs(sample.xi[c]) * to_output_ <= kLargestOutput) continue;
    defects_.Add("not_a_number", kChannelNames[c], t_s);
    known.xi[c] = kMissing;
  }
  missing_cells_.Add(t_s, known, info_.gyro_present, gap_limit_s_);
  while (const MissingCells::Sample* next = missing_cells_.Next()) Accept(*next);
}

void GyroStream::Accept(const MissingCells::Sample& sample) {
  const double t_s = sample.t_s;
  bool gap = false;
  if (!started()) {
    first_time_s_ = t_s;
    last_valid_t_s_.fill(t_s);
  } else {
    const double interval_s = t_s - last_time_s_;
    CountInterval(interval_s);
    gap = interval_s > gap_limit_s_;
    if (gap) {
      defects_.Add("gap", "gyro", last_time_s_);
      MarkBad(last_time_s_, t_s, {true, true, true});
    }
  }
  const Vector3 xi = Take(sample);
  if (ring_.count() >= 3) MendNewest(t_s, xi);
  WatchSettled();
  watched_t_s_ = t_s;
  for (std::size_t c = 0; c < 3; ++c) {
    const bool valid = info_.gyro_present[c] && std::isfinite(sample.as_it_came.xi[c]);
    watched_[c] = valid ? xi[c] : kMissing;
    if (valid) digits_[c].Add(xi[c]);
  }
  ring_.Push(t_s, xi, gap);
  last_time_s_ = t_s;
  freeze_.Add(t_s, sample.as_it_came);
  wrapped_.Add(t_s, sample.as_it_came.xi);
}

// The newest sample, now that the next one is there.
void GyroStream::MendNewest(double next_t_s, const Vector3& next) {
  const GyroRing::Point &first = back(3), &before = back(2), &newest = back(1);
  const double first_s = before.t_s - first.t_s, before_s = newest.t_s - before.t_s,
               after_s = next_t_s - newest.t_s;
  if (std::max({first_s, before_s, after_s}) > gap_limit_s_) return;
  Vector3 line = {}, off = {};
  for (std::size_t c = 0; c < 3; ++c) {
    line[c] = before.xi[c] + (next[c] - before.xi[c]) * before_s / (before_s + after_s);
    off[c] = std::fabs(newest.xi[c] - line[c]);
  }
  const double longest_s = std::max(before_s, after_s);
  std::array<bool, 3> wild = {};
  for (std::size_t c = 0; c < 3; ++c) {
    wild[c] = info_.gyro_present[c] && bends_ >= kBendsForLargeWild &&
              IsWild(c, off, off[c] / (per_deg_s_ * longest_s), next_t_s, next[c]);
  }
  for (std::size_t c = 0; c < 3; ++c) {
    if (wild[c]) Bridge(c, line[c]);
    const double chord =
        first.xi[c] + (newest.xi[c] - first.xi[c]) * first_s / (first_s + before_s);
    bend_[c][static_cast<std::size_t>(bends_) % kBends] = std::fabs(before.xi[c] - chord);
  }
  ++bends_;
}

double GyroStream::LargestBend(std::size_t c) const {
  return std::max(digit_, *std::max_element(bend_[c].begin(), bend_[c].end()));
}

// There are other channels, and they bend as they usually do: a knock would be felt by all.
bool GyroStream::OthersGoOn(std::size_t c, const Vector3& offs) const {
  bool any = false;
  for (std::size_t other = 0; other < 3; ++other) {
    if (other == c || !info_.gyro_present[other]) continue;
    any = true;
    if (offs[other] > kQuietBends * LargestBend(other)) return false;
  }
  return any;
}

// Even a turn about this channel's axis alone would be felt by one of the others: no sensor is
// mounted so well.
bool GyroStream::OthersWouldFeel(std::size_t c, const Vector3& offs) const {
  for (std::size_t other = 0; other < 3; ++other) {
    if (other != c && info_.gyro_present[other] &&
        kMisalignment * offs[c] > kQuietBends * LargestBend(other))
      return true;
  }
  return false;
}

bool GyroStream::IsWild(std::size_t c, const Vector3& offs, double off_deg_s2, double next_t_s,
                        double next) {
  if (off_deg_s2 < kLoneWild_deg_s2) return false;
  if (off_deg_s2 < kSmallWild_deg_s2 && !OthersGoOn(c, offs)) return false;
  const GyroRing::Point &first = back(3), &point = back(2);
  const double off = offs[c], before = point.xi[c], early_s = point.t_s - first.t_s;
  const double apart = std::max(std::fabs(next - before), std::fabs(before - first.xi[c]));
  if (apart > kNeighboursAgree * off) {
    // By how much the neighbours leave a line with the sample before them.
    const double slope = (next - before) / (next_t_s - point.t_s);
    const double leaves = std::fabs(before - first.xi[c] - slope * early_s);
    if (leaves > kNeighboursAgree * off || !OthersGoOn(c, offs)) return false;
  }
  const double bend = LargestBend(c);
  if (off_deg_s2 > kWildAcceleration_deg_s2) return off > kWildBends * bend;
  if (bends_ < static_cast<std::int64_t>(kBends)) return false;
  const bool quiet = apart <= kQuietBends * bend;
  if (off < (quiet ? kWildInQuietBends : kSmallWildBends) * bend) return false;
  if (OthersGoOn(c, offs) && OthersWouldFeel(c, offs)) return true;
  // What comes again is the motion of something that steps.
  const double since_s = back(1).t_s - std::exchange(last_small_wild_s_[c], back(1).t_s);
  return !(since_s < kSmallWildApart_s);
}

// Puts the newest sample on the line.
void GyroStream::Bridge(std::size_t c, double line) {
  const GyroRing::Point& newest = back(1);
  defects_.Add("gyro_outlier", kChannelNames[c], newest.t_s);
  watched_[c] = kMissing;
  ring_.Replace(c, line);
}

// The values of the channels in the output's unit; one that stays missing is held from before.
Vector3 GyroStream::Take(const MissingCells::Sample& sample) {
  const double t_s = sample.t_s;
  Vector3 out = {};
  for (std::size_t c = 0; c < 3; ++c) {
    if (!info_.gyro_present[c]) continue;
    const double value = sample.xi[c] * to_output_;
    if (!std::isfinite(value)) {
      out[c] = started() ? back(1).xi[c] : 0.0;
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
  }
  return out;
}

// The newest sample, which the next one may yet mend, waits.
void GyroStream::WatchSettled() {
  if (watched_t_s_) saturation_.Add(*watched_t_s_, watched_);
  watched_t_s_.reset();
}

std::vector<Defect> GyroStream::defects() const {
  DefectLog out = defects_;
  for (const auto& finding : Saturated())
    out.Add("saturation", kChannelNames[finding.channel], finding.first_t_s, finding.count);
  for (const FreezeWatch::Finding& finding : freeze_.Found())
    out.Add("frozen", "gyro", finding.begin_s, finding.samples);
  if (const auto found = wrapped_.Found()) {
    const Defect wrapped = DefectOf(*found);
    out.Add(wrapped.kind, wrapped.where, wrapped.first_t_s, wrapped.count);
  }
  return out.defects();
}

std::vector<BadStretch> GyroStream::bad() const {
  std::vector<BadStretch> out = bad_;
  for (const auto& finding : Saturated())
    out.insert(out.end(), finding.stretches.begin(), finding.stretches.end());
  for (const FreezeWatch::Finding& finding : freeze_.Found())
    out.push_back({finding.begin_s, finding.end_s, {true, true, true}});
  return out;
}

// With the newest sample as it is.
std::vector<SaturationWatch::Finding> GyroStream::Saturated() const {
  if (!watched_t_s_) return saturation_.Found();
  SaturationWatch with_newest = saturation_;
  with_newest.Add(*watched_t_s_, watched_);
  return with_newest.Found();
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
  if (ring_.count() == 8 || (ring_.count() & 1023) == 0) {
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

double GyroStream::RestBegin(double coarse_s) const { return Edges().Begin(coarse_s); }

double GyroStream::RestEnd(double coarse_s, double moving_s) const {
  return Edges().End(coarse_s, moving_s);
}

// A sensor without noise of its own still shows its last digit.
RestEdges GyroStream::Edges() const {
  constexpr double kOfADigit = 0.3;  // about that of one spread evenly, 1 / sqrt(12)
  const bool counts = info_.gyro_unit == RateUnit::kLsb;
  const double least = counts ? kOfADigit : std::max(0.01, kOfADigit * freeze_.digit_deg_s());
  return {ring_, info_.gyro_present, least};
}

}  // namespace gyrobench::calibration
