// Stamps that are rounded to fewer digits than the clock behind them runs evenly by.
#pragma once

#include <cstdint>

#include "calibration/signal/stamp_line.h"
#include "calibration/signal/whole_line.h"

namespace gyrobench::calibration {

// Of an interval of fewer digits a step does not say whether a sample was lost, and stamps stay as
// they are.
inline constexpr double kLeastDigitsOfInterval = 1.25;

// A sensor that samples at 100.3 Hz, logged in whole milliseconds, seems to turn for 10 ms or for
// 9 ms from one sample to the next: at 40 deg/s each angle is off by up to 0.02 deg, in a beat of
// the clock with the milliseconds that passes for a ripple of the angle. Stamps that lie about a
// straight line as rounding alone makes them are put on that line, by least squares of the last
// hundreds, and of a minute and more where the beat is as slow. Those of a clock that jitters stay
// as they are, and so do the first of a stretch and exact ones. Where the line of the whole is
// known from a first reading, all are put on that. Constant memory; what it gives depends on the
// stamps so far alone.
class EvenStamps {
 public:
  explicit EvenStamps(const KnownClock& known = {}) : known_(known) {}
  // In order; the same stamp again is given the same time again.
  double Mend(double stamp_s);
  // Of all stamps so far. The digit is 0 where nothing came yet, too.
  StampSteps Steps() const;
  // The line of all stamps so far, where they lie about it as rounding alone makes them, and digits
  // are so coarse that it matters; unknown else.
  KnownClock Clock() const;

 private:
  // Stamps of more digits need no mending: 10 us at 100 deg/s are a thousandth of a degree.
  static constexpr int kMostDigits = 4;

  void Begin(double stamp_s);
  bool IsOnKnownLine(double stamp_s, double* line_s) const;
  void FindDigits(double stamp_s);
  double Slope() const { return short_.square > 0.0 ? short_.slope_s() : first_step_s_; }
  double LineAt(double place) const;
  bool BeatsSlowly() const;
  double ShortMemory() const;
  bool Follows(double stamp_s, double step_s);
  bool MayBeJitter() const;
  void Add(double stamp_s);

  KnownClock known_;
  bool held_ = false;       // on the known line
  int digits_ = 0;          // behind the point, of all stamps so far
  double digit_s_ = 1.0;    // the last of them
  std::int64_t count_ = 0;  // of this stretch
  double first_s_ = 0.0, last_s_ = 0.0, last_mended_s_ = 0.0;
  double first_step_s_ = 0.0, shortest_step_s_ = 0.0;
  bool exact_ = true;   // every step is the same
  double place_ = 0.0;  // of the last stamp, in intervals from the first one
  StampLine short_, long_;
  LongestLine whole_;
  bool long_is_right_ = false;
  double share_of_long_ = 0.0;  // goes over slowly: a change of lines is no step
  StampSteps gaps_;             // of all stretches; without the digit
};

}  // namespace gyrobench::calibration
