// The straight line of an even clock through stamps, by least squares of the last of them.
#pragma once

#include <cstdint>

#include "base/measurement.h"

namespace gyrobench::calibration {

// A clock whose interval [s] is known as well as a line through so many stamps tells it; NaN where
// nobody knows, or there is none.
struct KnownClock {
  double interval_s = kMissing, told_by = 0.0;
  // Of stamps that all lie about one line of this interval: the first of them, and where the line
  // is there less that [s]. NaN where there are none.
  double first_stamp_s = kMissing, line_less_first_s = kMissing;
};

// How coarse stamps are, and the steps of more than a few digits from one to the next: gaps, where
// samples come every digit or so.
struct StampSteps {
  double digit_s = 0.0;  // last digit of the stamps; 0 where it is too fine to matter
  std::int64_t gaps = 0;
  double gaps_s = 0.0;
};

// Through places (in intervals from the first stamp) and stamps less the first one [s]. By how much
// stamps are beyond `step_s` a place: weight, means, sums about these. Steps are made those of the
// line now and then, as the variance about it would drown in rounding else.
struct StampLine {
  // Those before count for less by a factor of memory / (memory + 1) each, once they are as many.
  void Add(double place, double s, double memory);
  void MakeStepsItsOwn();
  double slope_s() const { return step_s + product / square; }
  double At(double place) const {
    return place * step_s + mean_s + product / square * (place - mean_place);
  }
  // What it leaves of the variance of the stamps.
  double left_s2() const { return (stamps_square - product * product / square) / weight; }

  double step_s = 0.0, weight = 1.0, mean_place = 0.0, mean_s = 0.0;
  double square = 0.0, product = 0.0, stamps_square = 0.0;
};

// The least time that a sample after one at `t_s` can have [s]: a line that moves is no step back.
double JustAfter(double t_s);

}  // namespace gyrobench::calibration
