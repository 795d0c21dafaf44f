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
// `Real`: double, or an array of some noises that pass side by side. Each interval waits for the
// one before, so that several take hardly longer than one; each comes out as it does alone.
template <typename Real>
class FilterOf {
 public:
  // Squares of N, K and s.
  FilterOf(const Real& n2, const Real& k2, const Real& s2) : n2_(n2), k2_(k2), s2_(s2), ee_(s2) {}

  void Advance(const Interval& interval) {
    using std::sqrt;
    if (interval.new_run) {
      bb_ = be_ = bc_ = Real(0.0);
    } else {
      bb_ += k2_ * interval.gap_before_s + n2_ * interval.bias_jump_per_s;
    }
    if (interval.begins_with_new_error()) {
      ee_ = s2_ * interval.begin_reference_share - n2_ * interval.begin_reference_walk_s;
      be_ = ec_ = Real(0.0);
    }
    const double dt = interval.duration_s;
    const double g = interval.still ? 0.0 : 1.0;  // of the reference's error in the output
    // May be negative: an error that only lessens what two neighbours would share without it.
    const Real end_s2 = s2_ * interval.end_reference_share - n2_ * interval.end_reference_walk_s;
    // I = int b dt over the interval, b' and c' = c + I its end values (exact process noise).
    const Real var_i = dt * dt * bb_ + k2_ * dt * dt * dt / 3.0;
    const Real cov_ib = dt * bb_ + 0.5 * k2_ * dt * dt;
    const Real cov_ie = dt * be_;
    const Real cov_ic = dt * bc_ + var_i;
    const Real bb = bb_ + k2_ * dt;
    const Real bc = bc_ + cov_ib;
    const Real cc = cc_ + 2.0 * dt * bc_ + var_i;
    const Real ec = ec_ + cov_ie;
    variance_ =
        var_i + n2_ * (dt + interval.more_walk_s) + g * (2.0 * cov_ie + g * ee_ + g * end_s2);
    const Real cov_yb = cov_ib + g * be_;
    const Real cov_yc = cov_ic + g * ec;
    const Real cov_ye = interval.still ? cov_ie : Real(-end_s2);
    const Real inverse = 1.0 / variance_;
    inverse_sigma_ = sqrt(inverse);
    gain_bias_ = cov_yb * inverse;
    gain_reference_ = cov_ye * inverse;
    gain_integral_ = cov_yc * inverse;
    bb_ = bb - gain_bias_ * cov_yb;
    bc_ = bc - gain_bias_ * cov_yc;
    cc_ = cc - gain_integral_ * cov_yc;
    if (interval.still) {
      ec_ = ec;
    } else {
      be_ = ec_ = Real(0.0);
      ee_ = end_s2;
    }
    be_ -= gain_bias_ * cov_ye;
    ec_ -= gain_integral_ * cov_ye;
    ee_ -= gain_reference_ * cov_ye;
  }
  // Of the last interval: what it does to columns under one of the noises (`of`: its value).
  template <typename Of>
  Step StepOf(const Interval& interval, const Of& of) const {
    Step step;
    step.bias_transition = interval.new_run ? 0.0 : 1.0;
    step.bias_factor = interval.duration_s;
    // A new reference begins from an estimate of 0; otherwise the last angle's stays while the
    // table is still.
    const bool new_error = interval.begins_with_new_error();
    step.reference_factor = new_error || interval.still ? 0.0 : 1.0;
    step.reference_transition = interval.still && !new_error ? 1.0 : 0.0;
    step.gain_bias = of(gain_bias_);
    step.gain_reference = of(gain_reference_);
    step.gain_integral = of(gain_integral_);
    step.inverse_sigma = of(inverse_sigma_);
    return step;
  }
  const Real& variance() const { return variance_; }  // of the last interval's output
  const Real& integral_variance() const { return cc_; }

 private:
  Real n2_, k2_, s2_;
  Real bb_{0.0}, be_{0.0}, bc_{0.0}, ee_, ec_{0.0}, cc_{0.0};
  Real variance_{1.0}, inverse_sigma_{1.0};
  Real gain_bias_{0.0}, gain_reference_{0.0}, gain_integral_{0.0};
};

// Of the covariance of all outputs: the sum of the logarithms of their variances, of a few at once.
class LogDeterminant {
 public:
  void Add(double variance) {
    constexpr int kTogether = 4;
    product_ *= variance;
    if (++count_ % kTogether != 0) return;
    sum_ += std::log(product_);
    product_ = 1.0;
  }
  double value() const { return sum_ + std::log(product_); }

 private:
  double sum_ = 0.0, product_ = 1.0;
  int count_ = 0;
};

}  // namespace gyrobench::calibration
