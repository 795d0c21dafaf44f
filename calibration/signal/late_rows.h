// Whether readings come as unevenly as their stamps say.
#pragma once

#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "base/measurement.h"
#include "calibration/signal/stamp_line.h"

namespace gyrobench::calibration {

// A computer that stamps what comes when it gets to it makes even readings look uneven; one that
// asks a device when it gets to it makes them so. The angle tells: at a steady rate it goes on
// evenly with the true times. Of three readings that are a lag apart, with d2 for the second
// difference,
//   d2(angle) = share * rate * d2(stamp) + noise
// by least squares over all steady turns: the share is 1 where each reading is of its stamp, and 0
// where the readings are even, which their stamps are not. A clock that wanders is seen at long
// lags alone. Constant memory.
class LateRows {
 public:
  // In readings. Of 64 the longest windows of a steady turn are 13 s at 10 Hz.
  static constexpr std::array<std::size_t, 3> kLags = {1, 8, 64};
  // `any_step`: also where readings may be missing, which counts for the stamps.
  explicit LateRows(bool any_step = false) : any_step_(any_step) {}
  // A reading of an axis [s, deg], in order.
  void Take(std::size_t axis, double stamp_s, double angle_deg);
  // The share and its standard error at the first lag, NaN and infinite where no turn tells.
  double share() const { return sums_[0].product / sums_[0].square; }
  double share_std_error() const { return StdError(sums_[0]); }
  // Whether the stamps alone are uneven, for sure.
  bool only_stamps() const;
  // Whether the readings are as uneven as the stamps, at some lag, for sure.
  bool of_their_stamps() const;
  // Mean square of d2(angle) - rate * d2(stamp) at a lag [deg^2]; NaN where too few turns tell.
  double Misfit_deg2(std::size_t lag) const;
  // What another recording of the same logger says, too.
  void Join(const LateRows& other);

 private:
  static constexpr std::size_t kRing = 129;
  struct Axis {
    std::array<double, kRing> stamp_s, angle_deg;
    std::size_t count = 0, since_missing = 0;
    std::size_t At(std::size_t back) const { return (count - 1 - back) % kRing; }
  };
  struct Sums {
    double count = 0.0, square = 0.0, product = 0.0, angles_square = 0.0;
  };
  double StdError(const Sums& sums) const;
  void TakeLag(const Axis& axis, std::size_t lag, Sums* sums);

  bool any_step_;
  std::array<Axis, 3> axes_ = {};
  std::array<Sums, kLags.size()> sums_ = {};
  double digit_deg_ = 360.0;  // the least difference of two readings in a row that is one
};

// The clocks of what comes evenly though its stamps do not: of the rows with samples of the gyro,
// and of each axis that is read in rows of its own.
struct EvenRows {
  KnownClock gyro;
  std::array<KnownClock, 3> reference;
  // Of stamps that are rounded to much of their interval, by the line of the whole recording.
  KnownClock rounded_gyro;
  std::array<KnownClock, 3> rounded_reference;
  // Samples that come as in packets are of their stamps: a loop that catches up asks as quickly.
  bool gyro_is_polled = false;
  // By which readings of the reference are put on the gyro's clock (clock_drift.h), even or not.
  double reference_drift_ppm = 0.0;
  bool any() const;
};

// What is known of the rows of one recording.
struct RowTiming {
  LateRows shared, own;      // readings in the rows of samples, and in others
  LateRows by_stamps{true};  // those in the rows of samples, nothing mended
  EvenRows clocks;           // whether or not they are even
  bool in_packets = false;   // most samples of the gyro
  std::int64_t put_on_line = 0, lost = 0;
};

// Of recordings by one logger, what comes evenly in each: what came in packets, and what the angles
// of all together show where its own say nothing else.
std::vector<EvenRows> RowsThatComeEvenly(std::span<const RowTiming> timings);

// Whether the angle of a recording goes on as evenly with the times of `mended` as with those of
// `before`, over all lags together, and hardly a row was lost on the way to them.
bool IsAsEvenAs(const RowTiming& mended, const RowTiming& before);

}  // namespace gyrobench::calibration
