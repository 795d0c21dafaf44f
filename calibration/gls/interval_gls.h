// Generalised least squares over a sequence of intervals, exact and in O(n p).
//
// Output of interval i, in deg:
//   y_i = x_i theta + int b dt + w_i - (e_i - e_{i-1})  moving: a reference angle at each end
//   y_i = x_i theta + int b dt + w_i                    still: true rotation 0, reference kept
//   w ~ N^2 dt           angle random walk, more of it where the samples are too few for the motion
//   b(0) = 0, db = K dW  bias random walk, since the first interval
//   e ~ s^2              error of one reference angle (of a stop, or of a node)
//
// The covariance of y is full, but a Kalman filter over (b, e) turns each column, and y, into
// innovations that are white and of unit variance under the noise: ordinary least squares on these
// is the exact GLS.
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "calibration/gls/noise_model.h"

namespace gyrobench::calibration {

using RowMajor = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

// Noise N is not taken for less than this [deg/sqrt(s)]: perfect data must not divide by zero.
inline constexpr double kLeastAngleRandomWalk = 1e-12;

// A column depends on those before it that leave less than this share of its square: that is
// rounding.
inline constexpr double kDependent = 1e-9;

struct Interval {
  double duration_s = 0.0;
  // Since the end of the interval before: nothing was measured, the bias walked on.
  double gap_before_s = 0.0;
  bool still = false;
  // The reference's error at the begin is not the one at the end of the interval before.
  bool new_reference = false;
  // Another power-on begins: its bias has a constant of its own and walks anew from it.
  bool new_run = false;
  // Variance of the reference's error at the end (moving) and at the begin (new reference) of the
  // interval, relative to s^2: less than 1 where it is a mean of several readings.
  double end_reference_share = 1.0, begin_reference_share = 1.0;
  // Where the end (begin) is a mean over several times: that much less N^2, for the random walk of
  // the angle is averaged as well (ReadingsMean::walk_s).
  double end_reference_walk_s = 0.0, begin_reference_walk_s = 0.0;
  // The output's variance is that much more N^2: the rate between the samples is not known.
  double more_walk_s = 0.0;
  // The bias jumps before the interval, by a variance of that much N^2 [1/s].
  double bias_jump_per_s = 0.0;
  // As `new_reference`, though nothing was left out: another axis begins to turn than the one that
  // turned last, and the reference misreads each by another angle.
  bool other_axis = false;

  // The reference's error at the begin is known by nothing that was before.
  bool begins_with_new_error() const { return new_reference || other_axis; }
  // Begins where the interval before ended, with the same errors.
  bool GoesOn() const { return gap_before_s == 0.0 && !begins_with_new_error() && !new_run; }
};

// Intervals and their columns, row by row. Which column is the output and which a regressor is said
// later.
class IntervalSeries {
 public:
  explicit IntervalSeries(int columns) : columns_(columns) {}
  void Reserve(std::size_t rows);
  // Adds an interval; returns its columns, zero, to be filled in.
  double* Add(const Interval& interval);

  int columns() const { return columns_; }
  std::size_t rows() const { return intervals_.size(); }
  const Interval& interval(std::size_t row) const { return intervals_[row]; }
  const std::vector<Interval>& intervals() const { return intervals_; }
  Eigen::Map<const RowMajor> values() const {
    return {values_.data(), static_cast<Eigen::Index>(rows()), columns_};
  }
  double* row(std::size_t row) { return values_.data() + row * static_cast<std::size_t>(columns_); }
  const double* row(std::size_t row) const {
    return values_.data() + row * static_cast<std::size_t>(columns_);
  }

 private:
  int columns_;
  std::vector<Interval> intervals_;
  std::vector<double> values_;
};

// All columns whitened under a noise, as products: what every later step needs.
struct WhiteGram {
  std::size_t rows = 0;
  Eigen::MatrixXd products;  // columns x columns: sum of whitened_i whitened_j
  double log_det = 0.0;      // of the covariance of y
};

WhiteGram Whiten(const IntervalSeries& series, const NoiseModel& noise);

// Share of a regressor's square below which what those before leave of it is rounding: then they
// are not independent.
inline constexpr double kLeastIndependentShare = 1e-13;

// Least squares of column `output` on the columns `regressors`.
struct GlsSolution {
  bool solvable = false;             // false: the regressors are not independent
  std::vector<double> coefficients;  // in the order of `regressors`
  std::vector<double> covariance;    // p x p, row-major; for the noise as given
  double residual_square = 0.0;      // sum of squares of the whitened residuals
  double log_det_information = 0.0;  // of X^T V^-1 X

  double variance(std::size_t i) const { return covariance[i * coefficients.size() + i]; }
};

GlsSolution Solve(const WhiteGram& gram, std::span<const int> regressors, int output);

// -2 log of the likelihood, and of the restricted likelihood (REML; only differences between noises
// with the same regressors mean anything), without their constants.
double Deviance(const WhiteGram& gram, const GlsSolution& solution);
double RestrictedDeviance(const WhiteGram& gram, const GlsSolution& solution);

// Takes sum_j coefficient_j column_j off the output column, in place: products of what is left keep
// their digits.
void Detrend(IntervalSeries* series, std::span<const int> regressors,
             std::span<const double> coefficients, int output);

// Ordinary least squares of the angles instead of their increments: the columns summed up along
// each stretch without a break, its mean removed. Knows nothing of the noise; weighs slow motion
// more and what happens from node to node less. Empty when the regressors are not independent.
std::vector<double> SolveAngles(const IntervalSeries& series, std::span<const int> regressors,
                                int output);

}  // namespace gyrobench::calibration
