#include "calibration/signal/saturation.h"

#include <algorithm>
#include <cmath>

namespace gyrobench::calibration {
namespace {

constexpr std::array<int, 7> kBits = {12, 14, 16, 18, 20, 24, 32};
constexpr std::int64_t kLeastAtRail = 3;
// Of a sensor that scales by itself.
constexpr double kLeastEnd_deg_s = 100.0;
constexpr std::int64_t kLeastRow = 4;
constexpr double kMostRepeats = 0.5;
constexpr double kChance = 1e-6;
// Stretches that are so near become one, so that the memory is bounded by the time.
constexpr double kMerged_s = 0.2;

}  // namespace

void SaturationWatch::Start(const MeasurementInfo& info) {
  *this = {};
  counts_ = info.gyro_unit == RateUnit::kLsb;
  zero_ = info.gyro_lsb_zero;
}

void SaturationWatch::Add(double t_s, const Vector3& value) {
  for (std::size_t c = 0; c < 3; ++c) {
    Channel& channel = channels_[c];
    const double x = value[c];
    if (!std::isfinite(x)) continue;
    range_.Add(c, t_s, x + zero_.value_or(0.0));
    const bool first = std::isnan(channel.last);
    const double interval_s = first ? 0.0 : t_s - channel.last_t_s;
    for (End& end : channel.ends) {
      // The sample after the end still belongs to it: what lies between the two is not known.
      if (end.row > 0 && !end.stretches.empty()) end.stretches.back().end_s = t_s;
    }
    Watch(&channel.ends[0], x, t_s, interval_s, c);
    Watch(&channel.ends[1], -x, t_s, interval_s, c);
    if (!first && channel.ends[0].row == 0 && channel.ends[1].row == 0) {
      ++channel.pairs;
      channel.repeats += x == channel.last ? 1 : 0;
    }
    channel.last = x;
    channel.last_t_s = t_s;
  }
}

void SaturationWatch::Watch(End* end, double signed_value, double t_s, double interval_s,
                            std::size_t c) {
  if (signed_value < end->value) {
    end->row = 0;
    return;
  }
  if (signed_value > end->value) {
    // The stretches keep their memory: on a ramp every sample is a new end.
    end->stretches.clear();
    end->value = signed_value;
    end->count = end->row = end->longest_row = 0;
    end->first_t_s = t_s;
  }
  ++end->count;
  end->longest_row = std::max(end->longest_row, ++end->row);
  if (!end->stretches.empty() && t_s - interval_s <= end->stretches.back().end_s + kMerged_s) {
    end->stretches.back().end_s = t_s;
    return;
  }
  BadStretch stretch{t_s - interval_s, t_s, {}};
  stretch.channel[c] = true;
  end->stretches.push_back(stretch);
}

bool SaturationWatch::IsUnsignedRail(double count) const {
  const double zero = zero_.value_or(UnsignedCounts::kZero);
  return std::any_of(kBits.begin(), kBits.end(), [&](int bits) {
    const double top = std::ldexp(1.0, bits) - 1.0;
    const bool middle = std::fabs(zero / (0.5 * top) - 1.0) < 0.25;
    return middle && range_.highest() <= top && (count == 0.0 || count == top);
  });
}

bool SaturationWatch::IsRail(double count, const End& end) const {
  const bool negative = range_.lowest() < 0.0;
  if (!negative && (zero_ || range_.Recognised()))
    return end.count >= kLeastAtRail && IsUnsignedRail(count);
  return std::any_of(kBits.begin(), kBits.end(), [&](int bits) {
    const double top = std::ldexp(1.0, bits - 1) - 1.0;
    if (range_.highest() > top || range_.lowest() < -top - 1.0) return false;
    const bool usual = bits == 16;
    if (count == top && !usual && !negative) return false;
    return (count == top || count == -top - 1.0) &&
           (usual ? end.count : end.longest_row) >= kLeastAtRail;
  });
}

// Longer in a row than the noise of this channel lets it be.
bool SaturationWatch::IsStuck(const Channel& channel, const End& end) const {
  if (std::fabs(end.value) < kLeastEnd_deg_s || end.longest_row < kLeastRow) return false;
  const double p = channel.pairs > 0
                       ? static_cast<double>(channel.repeats) / static_cast<double>(channel.pairs)
                       : 0.0;
  return p <= kMostRepeats && std::pow(p, static_cast<double>(end.longest_row - 1)) < kChance;
}

std::vector<SaturationWatch::Finding> SaturationWatch::Found() const {
  std::vector<Finding> found;
  for (std::size_t c = 0; c < 3; ++c) {
    for (std::size_t side = 0; side < 2; ++side) {
      const End& end = channels_[c].ends[side];
      if (end.count == 0) continue;
      const double value = side == 0 ? end.value : -end.value;
      const bool saturated =
          counts_ ? IsRail(value + zero_.value_or(0.0), end) : IsStuck(channels_[c], end);
      if (saturated) found.push_back({c, end.count, end.first_t_s, end.stretches});
    }
  }
  return found;
}

}  // namespace gyrobench::calibration
