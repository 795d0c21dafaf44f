#include <cmath>
#include <numeric>

#include "base/measurement.h"
#include "calibration/trace/held_out.h"
#include "calibration/trace/problem.h"

namespace gyrobench::calibration {
namespace {

constexpr double kWindow_s = 10.0;
constexpr Eigen::Index kLeastRowsOfWindow = 10;  // of a window whose error counts

// each(begin, end) of the windows of rows, one after the other. A break ends one.
template <typename Each>
void ForEachWindow(const ChannelProblem& problem, Eigen::Index begin, Eigen::Index end,
                   Each&& each) {
  Eigen::Index first = begin;
  for (Eigen::Index i = begin; i < end; ++i) {
    const Interval& interval = problem.intervals()[static_cast<std::size_t>(i)];
    const bool broken = interval.gap_before_s > 0 || interval.new_reference ||
                        (i > begin && problem.begin_s(i) < problem.begin_s(i - 1));
    if (i == first || !(broken || problem.end_s(i) - problem.begin_s(first) > kWindow_s)) continue;
    each(first, i);
    first = i;
  }
  if (end > first) each(first, end);
}

// The angle error in a window: increments summed up, the mean removed.
Eigen::VectorXd AngleErrorIn(const Eigen::VectorXd& increments_deg, Eigen::Index begin,
                             Eigen::Index end) {
  Eigen::VectorXd angle = increments_deg.segment(begin, end - begin);
  std::partial_sum(angle.begin(), angle.end(), angle.begin());
  return angle.array() - angle.mean();
}

}  // namespace

double Windows::rms() const {
  double sum = 0.0, n = 0.0;
  for (std::size_t i = 0; i < square.size(); ++i) {
    sum += square[i];
    n += count[i];
  }
  return n > 0 ? std::sqrt(sum / n) : kMissing;
}

void Windows::Append(const Windows& others) {
  square.insert(square.end(), others.square.begin(), others.square.end());
  count.insert(count.end(), others.count.begin(), others.count.end());
}

Windows AngleWindows(const ChannelProblem& problem, const Eigen::VectorXd& residual_deg,
                     Eigen::Index begin, Eigen::Index end) {
  Windows out;
  ForEachWindow(problem, begin, end, [&](Eigen::Index from, Eigen::Index to) {
    if (to - from < kLeastRowsOfWindow) return;
    out.square.push_back(AngleErrorIn(residual_deg, from, to).squaredNorm());
    out.count.push_back(static_cast<double>(to - from));
  });
  return out;
}

Eigen::VectorXd AngleErrors(const ChannelProblem& problem, const Eigen::VectorXd& residual_deg) {
  Eigen::VectorXd out(problem.rows());
  ForEachWindow(problem, 0, problem.rows(), [&](Eigen::Index from, Eigen::Index to) {
    out.segment(from, to - from) = AngleErrorIn(residual_deg, from, to);
  });
  return out;
}

}  // namespace gyrobench::calibration
