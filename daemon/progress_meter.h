// How much of a run is done, as the operator is told: never less than was said before.
#pragma once

#include <algorithm>

namespace gyrobench::daemon {

// By time against the plan, until the procedure says by itself how far it is.
class ProgressMeter {
 public:
  // Without effect once the procedure reports. 100 % is not said before the end.
  void AtTime(double elapsed_s, double planned_s) {
    if (reported_ || planned_s <= 0.0) return;
    fraction_ = std::max(fraction_, std::min(0.99, elapsed_s / planned_s));
  }

  // The procedure's own fraction, 0..1. What time had brought before its first report stays: the
  // procedure's part then leads from there to 1.
  void Report(double fraction) {
    if (!reported_ && fraction < fraction_) before_ = (fraction_ - fraction) / (1.0 - fraction);
    reported_ = true;
    fraction_ = std::clamp(before_ + (1.0 - before_) * fraction, fraction_, 1.0);
  }

  double fraction() const { return fraction_; }  // 0..1

 private:
  double fraction_ = 0.0;
  bool reported_ = false;
  double before_ = 0.0;  // fraction of the run before the part that the procedure reports
};

}  // namespace gyrobench::daemon
