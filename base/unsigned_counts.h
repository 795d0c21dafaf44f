// Counts of an unsigned 16-bit converter, told from those of a signed one.
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <limits>

namespace gyrobench {

// An unsigned converter of 16 bits gives 0 .. 65535 with its zero near 32768. A signed one of 16
// bits never passes 32767; a wider one does, but then its counts also go below 0 or beyond 65535,
// or they spend their rests near 0, which an unsigned converter only does at the end of its range.
// So the counts are unsigned where
//   - one channel at least has been on both sides of 32767 | 32768,
//   - no channel has left 0 .. 65535, and
//   - ten times as many samples lie in the middle quarter as in the lowest eighth of the range.
// All channels of a sensor come from converters of one kind. Judged anew with every sample.
class UnsignedCounts {
 public:
  static constexpr double kZero = 32768.0;
  static constexpr double kLargest = 65535.0;

  // A count of one channel at time `t_s`; NaN and fractions pass without harm.
  void Add(std::size_t channel, double t_s, double count) {
    if (!(count == count)) return;
    Side& side = sides_[channel];
    lowest_ = std::min(lowest_, count);
    highest_ = std::max(highest_, count);
    side.below = side.below || count < kZero;
    side.above = side.above || count >= kZero;
    if (side.below && side.above && !side.crossed) {
      side.crossed = true;
      first_crossing_s_ = std::min(first_crossing_s_, t_s);
    }
    ++samples_;
    middle_ += count >= 0.75 * kZero && count < 1.25 * kZero ? 1 : 0;
    low_ += count < 0.25 * kZero ? 1 : 0;
  }

  bool Recognised() const {
    const bool crossed =
        std::any_of(sides_.begin(), sides_.end(), [](const Side& side) { return side.crossed; });
    return crossed && lowest_ >= 0.0 && highest_ <= kLargest && middle_ > 10 * low_;
  }
  std::int64_t samples() const { return samples_; }
  // When a channel had first been on both sides. Infinite where none has.
  double first_crossing_s() const { return first_crossing_s_; }
  // Of all channels so far; infinite before the first.
  double lowest() const { return lowest_; }
  double highest() const { return highest_; }

 private:
  struct Side {
    bool below = false, above = false, crossed = false;
  };
  static constexpr double kInfinite = std::numeric_limits<double>::infinity();

  std::array<Side, 3> sides_ = {};
  double lowest_ = kInfinite, highest_ = -kInfinite, first_crossing_s_ = kInfinite;
  std::int64_t samples_ = 0, middle_ = 0, low_ = 0;
};

}  // namespace gyrobench
