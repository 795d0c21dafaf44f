// An encoder's registers as numbers, read in either order.
#pragma once

#include <cstdint>

#include "commission/measurements.h"
#include "config/device_maps.h"

namespace gyrobench::commission {

// From one value to the next, the shorter way round [counts].
std::int64_t Step(const config::EncoderMap& map, config::WordOrder order, const Words& before,
                  const Words& after);
inline config::WordOrder Other(config::WordOrder order) {
  return order == config::WordOrder::kHighFirst ? config::WordOrder::kLowFirst
                                                : config::WordOrder::kHighFirst;
}
inline const char* NameOf(config::WordOrder order) {
  return order == config::WordOrder::kHighFirst ? "high_first" : "low_first";
}

// What one turn of the table is likely to have in counts, where about `about` were seen: a power of
// two near it, else three digits of it.
double LikelyCounts(double about);
// The values of its range, with as many turns as before.
std::uint64_t RangeWith(const config::EncoderMap& map, double counts_per_turn);

}  // namespace gyrobench::commission
