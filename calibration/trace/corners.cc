#include "calibration/trace/corners.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <utility>
#include <vector>

#include "base/robust.h"
#include "calibration/gls/statistics.h"
#include "calibration/trace/problem.h"

namespace gyrobench::calibration {
namespace {

double Rate(const ChannelProblem& problem, std::size_t row) {
  return problem.output_deg()(static_cast<Eigen::Index>(row)) / problem.intervals()[row].duration_s;
}

// Of each row: whether a corner of the motion is seen in it or in its neighbours.
std::vector<bool> HasCorner(const ChannelProblem& problem, double walk_deg2_s) {
  constexpr double kCorner = 16.0;  // times the median, and what white noise makes of it
  constexpr double kOfNoise = 4.0 / 1200.0;
  const std::vector<Interval>& intervals = problem.intervals();
  std::vector<double> usual, moving;
  for (std::size_t i = 0; i < intervals.size(); ++i) {
    usual.push_back(problem.between(static_cast<Eigen::Index>(i)).corners_deg2 /
                    intervals[i].duration_s);
    if (!intervals[i].still) moving.push_back(usual.back());
  }
  if (moving.empty()) return std::vector<bool>(intervals.size(), false);
  const double limit = kCorner * std::max({Median(std::move(usual)), Median(std::move(moving)),
                                           kOfNoise * walk_deg2_s});
  std::vector<bool> out(intervals.size(), false);
  for (Eigen::Index i = 0; i < problem.rows(); ++i) {
    const auto goes_on = [&](Eigen::Index k) {
      return k > 0 && k < problem.rows() && intervals[static_cast<std::size_t>(k)].GoesOn();
    };
    double seen = 0.0, time_s = 0.0;
    for (Eigen::Index k = goes_on(i) ? i - 1 : i; k <= (goes_on(i + 1) ? i + 1 : i); ++k) {
      seen += problem.between(k).corners_deg2;
      time_s += intervals[static_cast<std::size_t>(k)].duration_s;
    }
    out[static_cast<std::size_t>(i)] = seen > limit * time_s;
  }
  return out;
}

// Of each row: whether the rate changes in it or beside it by more than noise.
std::vector<bool> Accelerates(const ChannelProblem& problem, double walk_deg2_s) {
  constexpr double kSquare = 36.0;  // of its standard deviations
  const std::vector<Interval>& intervals = problem.intervals();
  std::vector<bool> out(intervals.size(), false);
  for (std::size_t i = 1; i + 1 < intervals.size(); ++i) {
    if (!intervals[i].GoesOn() || !intervals[i + 1].GoesOn()) continue;
    const double change_deg_s = Rate(problem, i + 1) - Rate(problem, i - 1);
    const double variance =
        walk_deg2_s * (1.0 / intervals[i + 1].duration_s + 1.0 / intervals[i - 1].duration_s);
    if (change_deg_s * change_deg_s > kSquare * variance) out[i - 1] = out[i] = out[i + 1] = true;
  }
  return out;
}

}  // namespace

// Counts coarser than the noise hardly ever change: then the mean says more than the median.
double RoughWalk_deg2_s(const ChannelProblem& problem) {
  constexpr std::size_t kLeast = 30;
  const std::vector<Interval>& intervals = problem.intervals();
  std::vector<double> all, at_rest;
  for (std::size_t i = 2; i < intervals.size(); ++i) {
    if (!intervals[i].GoesOn() || !intervals[i - 1].GoesOn()) continue;
    const auto variance = [&](std::size_t k) { return 1.0 / intervals[k].duration_s; };
    const double second = Rate(problem, i) - 2.0 * Rate(problem, i - 1) + Rate(problem, i - 2);
    all.push_back(second * second / (variance(i) + 4.0 * variance(i - 1) + variance(i - 2)));
    if (intervals[i].still && intervals[i - 1].still && intervals[i - 2].still)
      at_rest.push_back(all.back());
  }
  std::vector<double>& squares = at_rest.size() < kLeast ? all : at_rest;
  if (squares.size() < kLeast) return kMissing;
  const double mean = Mean(squares);
  // Half of the squares of normal values are below 0.455.
  const double by_median = Median(std::move(squares)) / 0.455;
  return by_median > 0.1 * mean ? by_median : mean;
}

Corners CornersOf(const ChannelProblem& problem) {
  // Less than this part of the angle random walk over all that moves does not change a result.
  constexpr double kOpen = 0.02;
  // Less than this part of the angle random walk of a row is left out.
  constexpr double kCounts = 0.05;
  const Eigen::VectorXd none = Eigen::VectorXd::Zero(problem.rows());
  Corners out{none, none, none, none};
  const double walk_deg2_s = RoughWalk_deg2_s(problem);
  if (!(walk_deg2_s > 0.0)) return out;
  const std::vector<bool> has_corner = HasCorner(problem, walk_deg2_s),
                          accelerates = Accelerates(problem, walk_deg2_s);
  double moving_s = 0.0;
  for (Eigen::Index i = 0; i < problem.rows(); ++i) {
    const Interval& interval = problem.intervals()[static_cast<std::size_t>(i)];
    moving_s += interval.still ? 0.0 : interval.duration_s;
    const ChannelProblem::Between between = problem.between(i);
    const auto accelerate = [&](Eigen::Index a, Eigen::Index b) {
      return accelerates[static_cast<std::size_t>(a)] || accelerates[static_cast<std::size_t>(b)];
    };
    if (accelerate(i, std::min(i + 1, problem.rows() - 1))) {
      out.means_deg(i) += between.end.as_means_deg;
      out.means_before_deg(i) += between.end.as_means_later_deg;
    }
    if (accelerate(std::max(i - 1, Eigen::Index{0}), i)) {
      out.means_deg(i) -= between.begin.as_means_deg;
      out.means_before_deg(i) -= between.begin.as_means_later_deg;
    }
    out.squared_sigmas += std::pow(out.means_deg(i), 2) / (walk_deg2_s * interval.duration_s);
    if (!has_corner[static_cast<std::size_t>(i)]) continue;
    out.bends_deg(i) = between.bends_deg;
    const double open_s = (between.corners_deg2 + between.steps_deg2) / walk_deg2_s;
    if (open_s > kCounts * interval.duration_s) out.open_s(i) = open_s;
  }
  out.open = out.open_s.sum() > kOpen * moving_s;
  return out;
}

}  // namespace gyrobench::calibration
