#include "calibration/signal/freeze.h"

#include <algorithm>
#include <cmath>

#include "calibration/signal/output_unit.h"

namespace gyrobench::calibration {
namespace {

constexpr double kShortest_s = 0.3;
constexpr double kShortestOneChannel_s = 2.0;
constexpr std::int64_t kShortestSamples = 25;
constexpr double kFineDigit_deg_s = 0.02;
constexpr double kSameLevel_deg_s = 1.0;
constexpr double kSameLevelDigits = 5.0;
constexpr double kNoisyDigits = 2.5;    // three and more, whatever their rounding
constexpr double kMotionDigits = 12.5;  // beyond this a window says nothing of the noise
constexpr std::int64_t kLeastNoisy = 3;
constexpr std::size_t kMostRuns = 100'000;  // half a day of the shortest

bool SameOrBothMissing(double a, double b) { return a == b || (std::isnan(a) && std::isnan(b)); }

bool SameReading(const GyroSample& a, const GyroSample& b) {
  for (std::size_t c = 0; c < 3; ++c) {
    if (!SameOrBothMissing(a.xi[c], b.xi[c]) || !SameOrBothMissing(a.accel_g[c], b.accel_g[c]))
      return false;
  }
  return true;
}

int ChannelsOf(const GyroSample& sample) {
  int channels = 0;
  for (std::size_t c = 0; c < 3; ++c)
    channels += (std::isfinite(sample.xi[c]) ? 1 : 0) + (std::isfinite(sample.accel_g[c]) ? 1 : 0);
  return channels;
}

}  // namespace

void FreezeWatch::Start(const MeasurementInfo& info) {
  *this = {};
  info_ = info;
  to_deg_s_ = 1.0 / RoughUnitsPerDeg_s(info);
  runs_.reserve(64);
  levels_.reserve(kLevels);
}

// 0 of absent channels, NaN of missing values.
Vector3 FreezeWatch::Rates(const GyroSample& sample) const {
  Vector3 out = {};
  for (std::size_t c = 0; c < 3; ++c) {
    if (info_.gyro_present[c]) out[c] = sample.xi[c] * to_deg_s_;
  }
  return out;
}

bool FreezeWatch::IsLong(const Run& run) const {
  return channels_ > 0 && run.samples >= kShortestSamples &&
         run.end_s - run.begin_s >= (channels_ > 1 ? kShortest_s : kShortestOneChannel_s);
}

void FreezeWatch::Add(double t_s, const GyroSample& sample) {
  const Vector3 rate = Rates(sample);
  if (!last_ || !SameReading(*last_, sample)) {
    if (last_) EndRun(t_s, rate);
    run_ = {};
    run_.begin_s = t_s;
    run_.rate_deg_s = rate;
    channels_ = ChannelsOf(sample);
    last_ = sample;
  }
  ++run_.samples;
  run_.end_s = t_s;
  Look(t_s, rate);
}

void FreezeWatch::EndRun(double t_s, const Vector3& next_deg_s) {
  const double limit_deg_s = kWildAcceleration_deg_s2 * (t_s - run_.end_s);
  for (std::size_t c = 0; c < 3; ++c) {
    const double step = std::fabs(next_deg_s[c] - run_.rate_deg_s[c]);
    run_.woke_with_a_jump = run_.woke_with_a_jump || step > limit_deg_s;
    // Sums of decimals differ in their last bits.
    const bool counts = step > 1e-9 * std::fabs(next_deg_s[c]);
    if (counts && (least_step_deg_s_ == 0.0 || step < least_step_deg_s_)) least_step_deg_s_ = step;
  }
  if (IsLong(run_) && runs_.size() < kMostRuns) runs_.push_back(run_);
}

void FreezeWatch::Look(double t_s, const Vector3& rate_deg_s) {
  if (window_.samples == 0) window_ = {0, t_s, rate_deg_s, rate_deg_s};
  ++window_.samples;
  for (std::size_t c = 0; c < 3; ++c) {
    window_.low[c] = std::min(window_.low[c], rate_deg_s[c]);
    window_.high[c] = std::max(window_.high[c], rate_deg_s[c]);
  }
  if (window_.samples < kShortestSamples || t_s - window_.begin_s < kShortest_s) return;
  Classify();
  window_ = {};
}

void FreezeWatch::Classify() {
  double range_deg_s = 0.0;
  Vector3 middle = {};
  for (std::size_t c = 0; c < 3; ++c) {
    range_deg_s = std::max(range_deg_s, window_.high[c] - window_.low[c]);
    middle[c] = 0.5 * (window_.high[c] + window_.low[c]);
  }
  const double digits = range_deg_s == 0.0 ? 0.0 : range_deg_s / digit_deg_s();
  if (digits > kMotionDigits) return;
  Level* level = LevelAt(middle);
  if (level == nullptr) return;
  ++(digits == 0.0 ? level->still : digits < kNoisyDigits ? level->flickering : level->noisy);
}

bool FreezeWatch::SameLevel(const Vector3& a, const Vector3& b) const {
  const double near_deg_s = std::max(kSameLevel_deg_s, kSameLevelDigits * digit_deg_s());
  for (std::size_t c = 0; c < 3; ++c) {
    if (std::fabs(a[c] - b[c]) > near_deg_s) return false;
  }
  return true;
}

// nullptr where no room is left for another.
FreezeWatch::Level* FreezeWatch::LevelAt(const Vector3& rate_deg_s) {
  for (Level& level : levels_) {
    if (SameLevel(level.rate_deg_s, rate_deg_s)) return &level;
  }
  if (levels_.size() == kLevels) return nullptr;
  levels_.push_back({rate_deg_s});
  return &levels_.back();
}

double FreezeWatch::digit_deg_s() const {
  return info_.gyro_unit == RateUnit::kLsb ? std::fabs(to_deg_s_) : least_step_deg_s_;
}

bool FreezeWatch::IsFreeze(const Run& run) const {
  if (least_step_deg_s_ == 0.0 && runs_.empty()) return true;
  if (run.woke_with_a_jump || digit_deg_s() < kFineDigit_deg_s) return true;
  return std::any_of(levels_.begin(), levels_.end(), [&](const Level& level) {
    return SameLevel(level.rate_deg_s, run.rate_deg_s) && level.noisy >= kLeastNoisy &&
           level.noisy > 2 * level.flickering && 4 * level.noisy >= level.still;
  });
}

std::vector<FreezeWatch::Finding> FreezeWatch::Found() const {
  std::vector<Finding> found;
  for (const Run& run : runs_) {
    if (IsFreeze(run)) found.push_back(run);
  }
  if (IsLong(run_) && IsFreeze(run_)) found.push_back(run_);
  return found;
}

}  // namespace gyrobench::calibration
