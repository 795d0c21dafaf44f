// Counts of a signed word that were written as those of an unsigned one: 65535 for -1.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <optional>
#include <string>
#include <vector>

#include "base/measurement.h"

namespace gyrobench::calibration {

// A signed word of n bits that is written as an unsigned one begins again at 0 after 2^n - 1, where
// the rate goes through zero: from one sample to the next it jumps by nearly all of 2^n, and the
// motion goes on as if nothing was. A converter that is unsigned itself (base/unsigned_counts.h)
// has its zero in the middle of its range, from which no motion takes it from one end to the other
// between two samples. So the counts are wrapped where
//   - no channel has left 0 .. 2^n - 1, n = 16 or 32, and
//   - a channel has jumped by more than 15/16 of 2^n, three times at least: one stray sample at an
//     end makes two jumps.
class WrappedCounts {
 public:
  struct Finding {
    std::size_t channel = 0;  // that jumped most often
    int bits = 16;
    std::int64_t jumps = 0;
    double first_t_s = kMissing;
    double from = 0.0, to = 0.0;  // the counts before and after its first jump
  };

  void Start(const MeasurementInfo& info);
  // Counts of a sample as they came; NaN where missing.
  void Add(double t_s, const std::array<double, 3>& counts);
  // So far.
  std::optional<Finding> Found() const;

 private:
  struct Jumps {
    std::int64_t count = 0;
    double first_t_s = kMissing, from = 0.0, to = 0.0;
  };
  struct Channel {
    double last = kMissing;
    std::array<Jumps, 2> jumps;  // by kWords
  };

  bool watched_ = false;
  double lowest_ = std::numeric_limits<double>::infinity(), highest_ = -lowest_;
  std::array<Channel, 3> channels_;
};

inline constexpr const char* kWrappedCounts = "wrapped_counts";
// What was found, as a defect says it: "gyro z: 65533 to 4".
Defect DefectOf(const WrappedCounts::Finding& finding);
// Throws DataError where the defect is there: what it means and what to do.
void RefuseWrappedCounts(const std::string& source, const std::vector<Defect>& defects);

}  // namespace gyrobench::calibration
