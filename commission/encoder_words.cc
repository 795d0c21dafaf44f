#include "commission/encoder_words.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>

namespace gyrobench::commission {
namespace {

std::int64_t Value(const config::EncoderMap& map, config::WordOrder order, const Words& words) {
  if (map.words == 1) return words[0];
  const bool high_first = order == config::WordOrder::kHighFirst;
  const std::int64_t high = words[high_first ? 0 : 1], low = words[high_first ? 1 : 0];
  return high * 0x10000 + low;
}

std::int64_t Shorter(std::int64_t step, std::int64_t range) {
  step %= range;
  if (step > range / 2) step -= range;
  if (step < -range / 2) step += range;
  return step;
}

}  // namespace

std::int64_t Step(const config::EncoderMap& map, config::WordOrder order, const Words& before,
                  const Words& after) {
  const std::int64_t from = Value(map, order, before), to = Value(map, order, after);
  const std::int64_t all = std::int64_t{1} << (16 * map.words);
  const auto range = static_cast<std::int64_t>(map.range_counts);
  const std::int64_t step = Shorter(to - from, all);
  const bool within = from < range && to < range;
  const std::int64_t round = within ? Shorter(to - from, range) : step;
  return std::abs(round) < std::abs(step) ? round : step;
}

double LikelyCounts(double about) {
  constexpr double kNear = 0.06;  // the gyro's scale is known to a few percent
  const double power = std::exp2(std::round(std::log2(about)));
  if (std::fabs(about / power - 1.0) < kNear) return power;
  const double digit = std::pow(10.0, std::floor(std::log10(about)) - 2.0);
  return std::round(about / digit) * digit;
}

std::uint64_t RangeWith(const config::EncoderMap& map, double counts_per_turn) {
  const double turns = static_cast<double>(map.range_counts) / map.counts_per_turn;
  const double most = std::exp2(16.0 * map.words);
  return static_cast<std::uint64_t>(std::min(most, std::round(turns * counts_per_turn)));
}

}  // namespace gyrobench::commission
