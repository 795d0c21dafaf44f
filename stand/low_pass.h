// The gyro's digital filter, as far as its data sheet tells: a bandwidth and a group delay.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <numbers>

#include "config/scenario.h"

namespace gyrobench::stand {

// A first-order low-pass on means over steps of h, after a pure delay D:
//   y += a (u - y),   delay at low frequency = h/2 + h (1-a)/a + D = the data sheet's
// a follows from the bandwidth, or from the delay where that alone is already shorter than the lag
// of the bandwidth (the 5 and 10 Hz settings). The gain at rest is 1: the integral of y is that of
// u.
class LowPass {
 public:
  void Configure(double bandwidth_hz, double delay_s, double step_s) {
    a_ = -std::expm1(-step_s * 2.0 * std::numbers::pi * bandwidth_hz);
    pure_delay_s_ = delay_s - 0.5 * step_s - step_s * (1.0 - a_) / a_;
    if (pure_delay_s_ < 0.0) {
      a_ = std::min(1.0, step_s / (delay_s + 0.5 * step_s));
      pure_delay_s_ = std::max(0.0, delay_s - 0.5 * step_s - step_s * (1.0 - a_) / a_);
    }
  }
  // A lag alone: no delay beyond it.
  void ConfigureLag(double lag_s, double step_s) {
    a_ = step_s / (step_s + lag_s);
    pure_delay_s_ = 0.0;
  }
  double pure_delay_s() const { return pure_delay_s_; }
  // One step, or a fraction `a` of the way that stands for several with the same input.
  void Step(const config::Triple& u) { Step(u, a_); }
  void Step(const config::Triple& u, double a) {
    for (std::size_t i = 0; i < 3; ++i) y_[i] += a * (u[i] - y_[i]);
  }
  // For Step: `steps` steps in one.
  double Fraction(int steps) const { return 1.0 - std::pow(1.0 - a_, steps); }
  const config::Triple& value() const { return y_; }

 private:
  double a_ = 1.0;
  double pure_delay_s_ = 0.0;
  config::Triple y_ = {};
};

}  // namespace gyrobench::stand
