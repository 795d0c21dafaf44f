// The straight line of an even clock through the stamps of a whole recording.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

#include "base/measurement.h"
#include "calibration/signal/stamp_line.h"

namespace gyrobench::calibration {

// A line through the last minutes goes along with a beat that is slower than that. One through all
// stamps does not, and is right where one even clock gave them: what some hundreds of them show,
// the more thinned out the more there are.
class WholeLine {
 public:
  struct Line {
    double interval_s = 0.0;
    double at_first_s = 0.0;  // at place 0
    double scatter_s = 0.0;   // standard deviation of the stamps about it
  };

  // `place`: in intervals from the first stamp, growing; `s`: the stamp less the first one.
  void Add(double place, double s);
  std::int64_t count() const { return count_; }
  // Nothing of too few stamps, and of a clock that drifts: a parabola explains most of what a line
  // leaves of its stamps. Of a few sawteeth of a beat it explains less.
  std::optional<Line> Evenly() const;

 private:
  static constexpr std::size_t kMost = 512;
  struct Point {
    double place, s;
  };
  StampLine all_;
  std::vector<Point> points_;
  std::int64_t count_ = 0, every_ = 1;
};

// The line of the longest stretch of stamps.
class LongestLine {
 public:
  void Begin(double first_stamp_s);
  void Add(double place, double s) { now_.line.Add(place, s); }
  // `most_scatter_s`: about the line. Without one that is as near to all its stamps: unknown.
  KnownClock Clock(double most_scatter_s) const;

 private:
  struct Stretch {
    WholeLine line;
    double first_stamp_s = kMissing;
  };
  Stretch now_, longest_;
};

}  // namespace gyrobench::calibration
