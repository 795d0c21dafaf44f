// The stretches of a measurement whose data are bad for one channel.
#pragma once

#include <cmath>
#include <cstddef>
#include <limits>
#include <vector>

#include "calibration/signal/columns.h"

namespace gyrobench::calibration {

// Asked in the order of time. `stretches`: in the order of their begins; must outlive this.
class BadTimes {
 public:
  BadTimes(const std::vector<BadStretch>& stretches, std::size_t channel)
      : stretches_(stretches), channel_(channel) {}
  bool Touch(double begin_s, double end_s) {
    for (; next_ < stretches_.size() && stretches_[next_].begin_s <= end_s; ++next_)
      if (stretches_[next_].channel[channel_])
        until_s_ = std::fmax(until_s_, stretches_[next_].end_s);
    return until_s_ >= begin_s;
  }

 private:
  const std::vector<BadStretch>& stretches_;
  std::size_t channel_, next_ = 0;
  double until_s_ = -std::numeric_limits<double>::infinity();
};

}  // namespace gyrobench::calibration
