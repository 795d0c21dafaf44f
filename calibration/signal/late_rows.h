// Whether readings come as unevenly as their stamps say.
#pragma once

#include <array>
#include <cmath>
#include <cstddef>
#include <span>
#include <vector>

#include "base/measurement.h"

namespace gyrobench::calibration {

// What comes evenly though its stamps do not: the rows with samples of the gyro, and readings of the
// reference in rows of their own. Their interval [s], NaN where they do not, or nobody knows; and a
// line through how many stamps tells it as well.
struct EvenRows {
  double gyro_s = kMissing, reference_s = kMissing;
  double told_by = 0.0;
  bool any() const { return std::isfinite(gyro_s) || std::isfinite(reference_s); }
};

// A computer that stamps what comes when it gets to it makes even readings look uneven; one that
// asks a device when it gets to it makes them so. The angle tells: at a steady rate it goes on
// evenly with the true times. Of three readings in a row, with d2 for the second difference,
//   d2(angle) = share * rate * d2(stamp) + noise
// by least squares over all steady turns: share is 1 where each reading is of its stamp, and 0 where
// the stamps alone are uneven. Constant memory.
class LateRows {
 public:
  // A reading of an axis [s, deg], in order, its angle running on beyond a turn.
  void Take(std::size_t axis, double stamp_s, double angle_deg);
  // The share and its standard error, NaN and infinite where no turn tells.
  double share() const { return product_ / square_; }
  double share_std_error() const;
  // Whether the stamps alone are uneven, for sure.
  bool only_stamps() const;
  // What another recording of the same logger says, too.
  void Join(const LateRows& other);

 private:
  static constexpr std::size_t kWindow = 17, kMiddle = kWindow / 2;
  struct Axis {
    std::array<double, kWindow> stamp_s, angle_deg;
    std::size_t count = 0;  // so far, the last of them in the arrays
  };
  void TakeMiddleOf(const Axis& axis);

  std::array<Axis, 3> axes_ = {};
  double count_ = 0.0, square_ = 0.0, product_ = 0.0, angles_square_ = 0.0;
};

// What is known of the rows of one recording.
struct RowTiming {
  LateRows shared, own;  // readings in the rows of samples, and in others
  EvenRows interval;     // whether or not they come evenly
};

// Of recordings by one logger, what comes evenly in each: what came in packets, and what its angles
// show. The same computer stamps all: where it is late with the reference it is with the gyro.
std::vector<EvenRows> RowsThatComeEvenly(std::span<const RowTiming> timings);

}  // namespace gyrobench::calibration
