// The Kalman filter behind the generalised least squares of intervals (interval_gls.h): what each
// interval does to the covariance, and so to every column.
#pragma once

#include <cmath>

#include "calibration/gls/interval_gls.h"

namespace gyrobench::calibration {

// What one interval does to every column.
struct Step {
  double bias_transition = 1.0;   // of the bias state before; 0 where another run begins
  double bias_factor = 0.0;       // predicted output from the bias state
  double reference_factor = 0.0;  // and from the reference state
  double reference_transition = 0.0;
  double gain_bias = 0.0, gain_reference = 0.0, gain_integral = 0.0;
  double inverse_sigma = 1.0;
};

// Covariance of (b, e, c): bias deviation, error of the last reference angle, integral of b so far.
class CovarianceFilter {
 public:
  explicit CovarianceFilter(const NoiseModel& noise)
      : n2_(noise.angle_random_walk_deg_sqrt_s * noise.angle_random_walk_deg_sqrt_s),
        k2_(noise.bias_random_walk_deg_s_sqrt_s * noise.bias_random_walk_deg_s_sqrt_s),
        s2_(noise.reference_deg * noise.reference_deg) {
    ee_ = s2_;
  }

  Step Advance(const Interval& interval) {
    bb_ = interval.new_run ? 0.0 : bb_ + k2_ * interval.gap_before_s;
    if (interval.new_run) be_ = bc_ = 0.0;
    if (interval.new_reference) {
      ee_ = s2_ * interval.begin_reference_share - n2_ * interval.begin_reference_walk_s;
      be_ = ec_ = 0.0;
    }
    const double dt = interval.duration_s;
    const double g = interval.still ? 0.0 : 1.0;  // of the reference's error in the output
    // May be negative: an error that only lessens what two neighbours would share without it.
    const double end_s2 = s2_ * interval.end_reference_share - n2_ * interval.end_reference_walk_s;
    // I = int b dt over the interval, b' and c' = c + I its end values (exact process noise).
    const double var_i = dt * dt * bb_ + k2_ * dt * dt * dt / 3.0;
    const double cov_ib = dt * bb_ + 0.5 * k2_ * dt * dt;
    const double cov_ie = dt * be_;
    const double cov_ic = dt * bc_ + var_i;
    const double bb = bb_ + k2_ * dt;
    const double bc = bc_ + cov_ib;
    const double cc = cc_ + 2.0 * dt * bc_ + var_i;
    const double ec = ec_ + cov_ie;
    const double variance = var_i + n2_ * dt + g * (2.0 * cov_ie + g * ee_ + g * end_s2);
    Step step;
    step.bias_transition = interval.new_run ? 0.0 : 1.0;
    step.bias_factor = dt;
    // A new reference begins from an estimate of 0; otherwise the last angle's stays while the
    // table is still.
    step.reference_factor = interval.new_reference ? 0.0 : g;
    step.reference_transition = interval.still && !interval.new_reference ? 1.0 : 0.0;
    const double cov_yb = cov_ib + g * be_;
    const double cov_yc = cov_ic + g * ec;
    const double cov_ye = interval.still ? cov_ie : -end_s2;
    variance_ = variance;
    const double inverse = 1.0 / variance;
    step.inverse_sigma = std::sqrt(inverse);
    step.gain_bias = cov_yb * inverse;
    step.gain_reference = cov_ye * inverse;
    step.gain_integral = cov_yc * inverse;
    bb_ = bb - step.gain_bias * cov_yb;
    bc_ = bc - step.gain_bias * cov_yc;
    cc_ = cc - step.gain_integral * cov_yc;
    be_ = (interval.still ? be_ : 0.0) - step.gain_bias * cov_ye;
    ec_ = (interval.still ? ec : 0.0) - step.gain_integral * cov_ye;
    ee_ = (interval.still ? ee_ : end_s2) - step.gain_reference * cov_ye;
    return step;
  }
  double variance() const { return variance_; }  // of the last interval's output
  double integral_variance() const { return cc_; }

 private:
  double n2_, k2_, s2_;
  double bb_ = 0, be_ = 0, bc_ = 0, ee_ = 0, ec_ = 0, cc_ = 0;
  double variance_ = 1.0;
};

}  // namespace gyrobench::calibration
