// The angle error that matters to a user: in short windows, each one's mean removed.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "calibration/trace/problem.h"

namespace gyrobench::calibration {

// Root mean square of the angle error in windows of 10 s, the mean of each taken off, of residual
// increments [deg]; one square sum and count a window.
struct Windows {
  std::vector<double> square, count;
  double rms() const;
  void Append(const Windows& others);
};
Windows AngleWindows(const ChannelProblem& problem, const Eigen::VectorXd& residual_deg,
                     Eigen::Index begin, Eigen::Index end);
// The angle error [deg] at the end of every row, in the same windows.
Eigen::VectorXd AngleErrors(const ChannelProblem& problem, const Eigen::VectorXd& residual_deg);

}  // namespace gyrobench::calibration
