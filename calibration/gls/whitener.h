// Whitening of single columns under one noise, and the scores of shocks at every time.
#pragma once

#include <Eigen/Core>
#include <span>
#include <vector>

#include "calibration/gls/interval_filter.h"
#include "calibration/gls/interval_gls.h"
#include "calibration/gls/raw_columns.h"

namespace gyrobench::calibration {

// The filter's steps are worked out once; every column then passes in O(n).
class Whitener {
 public:
  Whitener(std::span<const Interval> intervals, const NoiseModel& noise);

  std::size_t rows() const { return steps_.size(); }
  double log_det() const { return log_det_; }  // of the covariance of the output
  // columns: rows x p; each becomes the filter's innovations, white under the noise. `first`: their
  // first row, at which a power-on begins.
  void Apply(Eigen::Ref<Eigen::MatrixXd> columns, Eigen::Index first = 0) const;
  // The same of raw columns of rows() rows each, which stay as they are: side by side in `white`
  // (rows() x all of them).
  void Whiten(std::span<const RawColumns> raw, Eigen::Ref<Eigen::MatrixXd> white) const;
  // Of each column, were it the output: the integral of the bias deviation over all intervals, as
  // the filter sees it at the end [deg for an output in deg]. It is linear in the column; its
  // variance depends on the noise alone.
  Eigen::VectorXd WalkIntegrals(const Eigen::Ref<const RowMajor>& columns) const;
  double walk_integral_variance() const { return walk_integral_variance_; }

  // Scores of shocks, for white columns (disturbance smoother; Harvey and Koopman 1992): row i of
  //   bias    score of a bias that is higher by 1 deg/s from interval i on
  //   output  score of interval i's output being higher by 1 deg
  // Their variances under the noise, before anything is fitted.
  struct Shocks {
    Eigen::MatrixXd bias, output;  // rows() x p
    Eigen::VectorXd bias_information, output_information;
  };
  Shocks Scores(const Eigen::MatrixXd& white) const;

 private:
  struct Smoother;
  void Smooth(Eigen::Index begin, Smoother* smoother, RowMajor* rows, RowMajor* bias,
              Shocks* out) const;

  std::vector<Step> steps_;
  double log_det_ = 0.0, walk_integral_variance_ = 0.0;
};

}  // namespace gyrobench::calibration
