#include "calibration/signal/rest_edges.h"

#include <algorithm>
#include <cmath>

namespace gyrobench::calibration {
namespace {

// Rotation at rest: beyond so many standard deviations of the sample at rest.
constexpr double kMotionSigmas = 8.0;
constexpr double kSearch_s = 0.3;
constexpr double kLongestOnset_s = 0.06;
// Used where the gyro does not feel the motion: covers the latency of a bus and of a filter.
constexpr double kGuard_s = 0.03;

}  // namespace

RestEdges::Quiet RestEdges::QuietBetween(double begin_s, double end_s) const {
  Quiet quiet;
  Vector3 sum = {}, square = {};
  const std::int64_t begin = ring_.FirstNotBefore(begin_s), end = ring_.FirstNotBefore(end_s);
  for (std::int64_t i = begin; i < end; ++i) {
    for (std::size_t c = 0; c < 3; ++c) sum[c] += ring_.at(i).xi[c];
  }
  quiet.samples = static_cast<int>(end - begin);
  const double n = std::max(1.0, static_cast<double>(quiet.samples));
  for (std::size_t c = 0; c < 3; ++c) quiet.mean[c] = sum[c] / n;
  for (std::int64_t i = begin; i < end; ++i) {
    for (std::size_t c = 0; c < 3; ++c) square[c] += std::pow(ring_.at(i).xi[c] - quiet.mean[c], 2);
  }
  for (std::size_t c = 0; c < 3; ++c) {
    quiet.threshold[c] =
        kMotionSigmas * std::max(digit_, std::sqrt(square[c] / std::max(1.0, n - 1)));
  }
  return quiet;
}

// The largest deviation of a sample among the channels, in units of the channel's threshold.
double RestEdges::Deviation(const Quiet& quiet, std::int64_t index) const {
  double largest = 0.0;
  for (std::size_t c = 0; c < 3; ++c) {
    if (!present_[c]) continue;
    largest =
        std::max(largest, std::fabs(ring_.at(index).xi[c] - quiet.mean[c]) / quiet.threshold[c]);
  }
  return largest;
}

double RestEdges::Begin(double coarse_s) const {
  const Quiet quiet = QuietBetween(coarse_s + 0.2, coarse_s + 0.45);
  if (quiet.samples < 8) return coarse_s + kGuard_s;
  const std::int64_t first = ring_.FirstNotBefore(coarse_s - kSearch_s);
  for (std::int64_t i = ring_.FirstNotBefore(coarse_s + 0.2); i > first; --i) {
    const double here = Deviation(quiet, i);
    if (here <= 1.0 || i + 1 >= ring_.count()) continue;
    const double interval_s = ring_.at(i).t_s - ring_.at(i - 1).t_s;
    const double before = Deviation(quiet, i - 1);
    // The rate falls linearly to zero while the table brakes.
    const double onset_s = before > here ? here * interval_s / (before - here) : 0.0;
    return std::max(ring_.at(i + 1).t_s, ring_.at(i).t_s + std::min(onset_s, kLongestOnset_s)) +
           interval_s;
  }
  return coarse_s + kGuard_s;
}

double RestEdges::End(double coarse_s, double moving_s) const {
  const Quiet quiet = QuietBetween(coarse_s - 0.5, coarse_s - 0.15);
  if (quiet.samples < 8) return coarse_s - kGuard_s;
  const std::int64_t end = ring_.FirstNotBefore(moving_s + 0.1);
  for (std::int64_t i = std::max(ring_.oldest() + 1, ring_.FirstNotBefore(coarse_s - 0.15));
       i < end; ++i) {
    const double here = Deviation(quiet, i);
    if (here <= 1.0 || i + 1 >= ring_.count()) continue;
    const double interval_s = ring_.at(i + 1).t_s - ring_.at(i).t_s;
    const double after = Deviation(quiet, i + 1);
    const double onset_s = after > here ? here * interval_s / (after - here) : 0.0;
    return std::min(ring_.at(i - 1).t_s, ring_.at(i).t_s - std::min(onset_s, kLongestOnset_s)) -
           interval_s;
  }
  return coarse_s - kGuard_s;
}

}  // namespace gyrobench::calibration
