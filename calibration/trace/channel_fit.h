// The numbers of a chosen model, their errors, and what the model is worth on data it did not see.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <vector>

#include "calibration/trace/problem.h"
#include "calibration/trace/selection.h"
#include "calibration/trace/trace_result.h"

namespace gyrobench::calibration {

// Parameters in the order: baseline columns, then member by member its linear coefficients and its
// non-linear parameters.
struct ChannelFit {
  Eigen::VectorXd values;
  Eigen::MatrixXd covariance;              // at the Cramer-Rao bound, for the noise as estimated
  std::vector<Eigen::Index> member_begin;  // of each member's parameters
  Eigen::MatrixXd raw;                     // rows x linear columns (baseline, members)
  Eigen::MatrixXd white;                   // the same, whitened
  Eigen::VectorXd linear;                  // coefficients of these columns
  std::vector<Eigen::Index> column_begin;  // of each member, in raw and white
  Eigen::VectorXd white_output;
  Eigen::Index baseline_columns = 0;

  Eigen::VectorXd WhiteResidual() const { return white_output - white * linear; }
  double whitened_rms() const;
  // Columns of raw and white that belong to a member.
  std::vector<Eigen::Index> ColumnsOf(std::size_t member) const;
};

ChannelFit FitChannel(const ChannelProblem& problem, const Baseline& baseline,
                      const Selection& selection);

// Whitened RMS and angle error on data that the fit did not see: by whole measurements where there
// are three and more; else ten times a tenth of short blocks in time, which cover what the rest of
// the blocks do. `without`: columns of `fit.raw` that the model
// before leaves out; the model after has all.
struct HeldOutFigures {
  HeldOut whitened_rms, angle_rms_deg;
};
HeldOutFigures HoldOut(const ChannelProblem& problem, const ChannelFit& fit,
                       const std::vector<Eigen::Index>& without, std::uint64_t seed);
// The angle error, trained on the first 60 % of the time and tested on the rest. The bias goes on
// where the noise says that it has walked to.
HeldOut Forecast(const ChannelProblem& problem, const ChannelFit& fit, const IntervalNoise& noise,
                 std::uint64_t seed);

// Root mean square of the angle error in windows of 10 s, the mean of each taken off, of residual
// increments [deg]; one square sum and count a window.
struct Windows {
  std::vector<double> square, count;
  double rms() const;
  void Append(const Windows& others);
};
Windows AngleWindows(const ChannelProblem& problem, const Eigen::VectorXd& residual_deg,
                     Eigen::Index begin, Eigen::Index end);

}  // namespace gyrobench::calibration
