// Whether the gyro's output stood at the end of its range.
#pragma once

#include <array>
#include <cstdint>
#include <limits>
#include <optional>
#include <vector>

#include "base/measurement.h"
#include "base/unsigned_counts.h"
#include "calibration/signal/columns.h"

namespace gyrobench::calibration {

// A saturated output stands at its largest value while the rate goes on beyond it. Watched are the
// largest and the smallest value of each channel so far, and how often and how long the output
// stood at exactly that value; whether this was a saturation is judged from all samples so far, so
// that a value beyond takes back what was said of the one below it:
//   - counts saturate at an end of their converter only: 2^(n-1) - 1 and -2^(n-1) where it is
//     signed, 0 and 2^n - 1 where it is unsigned (gyro_lsb_zero is given, or UnsignedCounts
//     recognises it), n = 12, 14, 16, 18, 20, 24, 32, and no channel beyond the ends of the same
//     n bits. The upper end of fewer than 16 bits also needs a negative count, for 2047 is the zero
//     of an unsigned converter of 12 bits. 16-bit ends count from the third sample on, in a row or
//     not; others from three in a row;
//   - a sensor that scales by itself has an end that nobody declared: over 100 deg/s, and so many
//     equal samples in a row as its noise would give once in a million: with p the share of
//     samples that equal the one before, p^(n - 1) < 1e-6, and at least 4. A sensor that repeats
//     more than half of its samples, because its digit is coarser than its noise, cannot be
//     judged: on a steady turn it stands still as well.
class SaturationWatch {
 public:
  struct Finding {
    std::size_t channel = 0;
    std::int64_t count = 0;
    double first_t_s = kMissing;
    std::vector<BadStretch> stretches;  // from the sample before to the one after
  };

  void Start(const MeasurementInfo& info);
  // Values of a sample that nothing will mend any more: counts, or deg/s; NaN where missing.
  void Add(double t_s, const Vector3& value);
  // So far.
  std::vector<Finding> Found() const;
  // So far: counts of an unsigned converter whose zero nobody gave.
  bool unsigned_counts() const { return counts_ && !zero_ && range_.Recognised(); }

 private:
  struct End {
    double value = -std::numeric_limits<double>::infinity();  // times the end's sign
    std::int64_t count = 0, row = 0, longest_row = 0;
    double first_t_s = kMissing;
    std::vector<BadStretch> stretches;
  };
  struct Channel {
    std::array<End, 2> ends;  // largest, smallest
    double last = kMissing, last_t_s = kMissing;
    std::int64_t pairs = 0, repeats = 0;  // of samples that are at neither end
  };

  static void Watch(End* end, double signed_value, double t_s, double interval_s, std::size_t c);
  bool IsRail(double count, const End& end) const;
  bool IsUnsignedRail(double count) const;
  bool IsStuck(const Channel& channel, const End& end) const;

  bool counts_ = true;
  std::optional<double> zero_;  // given
  UnsignedCounts range_;        // of all channels, in counts of the converter
  std::array<Channel, 3> channels_;
};

}  // namespace gyrobench::calibration
