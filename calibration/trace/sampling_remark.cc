// Whether the gyro is sampled often enough for its motion.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <vector>

#include "calibration/trace/problem.h"
#include "calibration/trace/report_parts.h"

namespace gyrobench::calibration {
namespace {

bool GoesOn(const Interval& interval) {
  return interval.gap_before_s == 0.0 && !interval.new_run && !interval.new_reference;
}

}  // namespace

// Between samples tau apart the trapezoid rule is off by d tau^2 f (1 - f) / 2 where the
// acceleration changes by d, f being the part of the interval that is over then: in the mean square
// over f by d^2 tau^4 / 120, at most by d tau^2 / 8.
std::string RemarkOnSampling(const ChannelProblem& problem, const NoiseModel& noise) {
  constexpr double kMeanSquare = 1.0 / 120.0, kMost = 1.0 / 8.0;
  constexpr double kBesideNoise = 0.5;  // of the angle random walk, while the table moves
  // What a change at one moment, and N^2, add to the square of a change less the mean of those
  // before and after it, which is next to nothing in a motion without corners.
  constexpr double kOfCorner = 2.0 / 3.0, kOfNoise = 17.5;
  const double n2 = std::pow(noise.angle_random_walk_deg_sqrt_s, 2);
  const std::vector<Interval>& intervals = problem.intervals();
  const auto rate = [&](std::size_t i) {
    return problem.output_deg()(static_cast<Eigen::Index>(i)) / intervals[i].duration_s;
  };
  // Of the acceleration, from the interval before to the one after.
  const auto change = [&](std::size_t i) {
    const auto slope = [&](std::size_t k) {
      return (rate(k + 1) - rate(k)) /
             (0.5 * (intervals[k].duration_s + intervals[k + 1].duration_s));
    };
    return slope(i) - slope(i - 1);
  };
  double square_deg2 = 0.0, walk_deg2 = 0.0, largest_deg = 0.0, longest_s = 0.0;
  std::size_t whole = 0;  // intervals in a row
  for (std::size_t i = 0; i < intervals.size(); ++i) {
    whole = GoesOn(intervals[i]) ? whole + 1 : 1;
    if (whole < 5 || intervals[i - 2].still) continue;
    const std::size_t middle = i - 2;
    const double tau_s =
        problem.history(static_cast<Eigen::Index>(middle)).recording->median_interval_s;
    const double corner = change(middle) - 0.5 * (change(middle - 1) + change(middle + 1));
    const double of_noise = kOfNoise * n2 / std::pow(intervals[middle].duration_s, 3);
    square_deg2 += kMeanSquare * std::pow(tau_s, 4) * (corner * corner - of_noise) / kOfCorner;
    walk_deg2 += n2 * intervals[middle].duration_s;
    largest_deg = std::max(largest_deg, kMost * std::fabs(corner) * tau_s * tau_s);
    longest_s = std::max(longest_s, tau_s);
  }
  if (!(square_deg2 > kBesideNoise * walk_deg2)) return "";
  return fmt::format(
      "the gyro is sampled every {:.3g} s, seldom for such motion: if a sample is the rate of its "
      "moment, and not the mean since the one before, the begin and the end of a ramp are each "
      "integrated wrong by up to {:.1g} deg, and a play, a ripple or a step that is named here may "
      "be nothing but that; log the gyro faster, or turn it with gentler ramps",
      longest_s, largest_deg);
}

}  // namespace gyrobench::calibration
