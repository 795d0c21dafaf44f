// Whether the gyro is sampled often enough for its motion.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <string>
#include <vector>

#include "base/robust.h"
#include "calibration/gls/statistics.h"
#include "calibration/trace/problem.h"
#include "calibration/trace/report_parts.h"

namespace gyrobench::calibration {
namespace {

bool GoesOn(const Interval& interval) {
  return interval.gap_before_s == 0.0 && !interval.new_run && !interval.new_reference;
}

// Changes of the acceleration at a moment.
class Corners {
 public:
  Corners(const ChannelProblem& problem, const NoiseModel& noise)
      : problem_(problem), noise_(noise), intervals_(problem.intervals()) {
    std::size_t in_a_row = 0;
    for (std::size_t i = 0; i < intervals_.size(); ++i) {
      in_a_row = GoesOn(intervals_[i]) ? in_a_row + 1 : 1;
      if (in_a_row >= 5 && !intervals_[i - 2].still) Take(i - 2);
    }
  }

  // A motion that bends all the time has no corners: half of it is as bent as the rest.
  bool stand_alone() const {
    constexpr double kFew = 0.25;  // of the mean square; of a Gaussian motion it is 0.45
    return !squares_.empty() && Median(squares_) < kFew * Mean(squares_);
  }
  // Of the integral, in the mean square over where in its interval between samples a corner lies.
  double error_deg2() const { return error_deg2_; }
  double walk_deg2() const { return walk_deg2_; }  // of the noise, meanwhile
  double largest_deg() const { return largest_deg_; }
  double interval_s() const { return interval_s_; }

 private:
  // Where the acceleration changes by d the integral of the spline through samples tau apart is off
  // by d tau^2 (f (1 - f) / 2 - 1 / 12), f being the part of the interval that is over then: in the
  // mean square by d^2 tau^4 / 720, at most by d tau^2 / 12.
  void Take(std::size_t i) {
    constexpr double kMeanSquare = 1.0 / 720.0, kMost = 1.0 / 12.0;
    // A change less the mean of those before and after it, of rates that are means of T: what d
    // adds to its square, and N^2 / T^3 and s^2 / T^4; the most of d that one can be.
    constexpr double kOfCorner = 0.4, kOfWalk = 17.5, kOfReference = 63.0, kMostOfCorner = 0.625;
    const double step = Change(i) - 0.5 * (Change(i - 1) + Change(i + 1));
    const double span_s = intervals_[i].duration_s;
    const double n2 = std::pow(noise_.angle_random_walk_deg_sqrt_s, 2);
    const double s2 = std::pow(noise_.reference_deg, 2);
    const double of_noise =
        kOfWalk * n2 / std::pow(span_s, 3) + kOfReference * s2 / std::pow(span_s, 4);
    const double tau_s =
        problem_.history(static_cast<Eigen::Index>(i)).recording->median_interval_s;
    squares_.push_back(step * step);
    error_deg2_ += kMeanSquare * std::pow(tau_s, 4) * (step * step - of_noise) / kOfCorner;
    walk_deg2_ += n2 * span_s;
    largest_deg_ = std::max(largest_deg_, kMost * std::fabs(step) / kMostOfCorner * tau_s * tau_s);
    interval_s_ = std::max(interval_s_, tau_s);
  }
  double Rate(std::size_t i) const {
    return problem_.output_deg()(static_cast<Eigen::Index>(i)) / intervals_[i].duration_s;
  }
  double Slope(std::size_t i) const {
    return (Rate(i + 1) - Rate(i)) /
           (0.5 * (intervals_[i].duration_s + intervals_[i + 1].duration_s));
  }
  // Of the acceleration, from before to after the interval.
  double Change(std::size_t i) const { return Slope(i) - Slope(i - 1); }

  const ChannelProblem& problem_;
  const NoiseModel& noise_;
  const std::vector<Interval>& intervals_;
  std::vector<double> squares_;
  double error_deg2_ = 0.0, walk_deg2_ = 0.0, largest_deg_ = 0.0, interval_s_ = 0.0;
};

}  // namespace

std::string RemarkOnSampling(const ChannelProblem& problem, const NoiseModel& noise) {
  constexpr double kBesideNoise = 0.5;  // of the angle random walk, while the table moves
  const Corners corners(problem, noise);
  if (!corners.stand_alone() || !(corners.error_deg2() > kBesideNoise * corners.walk_deg2()))
    return "";
  return fmt::format(
      "the gyro is sampled every {:.3g} s, seldom for such motion: if a sample is the rate of its "
      "moment, and not the mean since the one before, the begin and the end of a ramp are each "
      "integrated wrong by up to {:.1g} deg, and a play, a ripple or a step that is named here may "
      "be nothing but that; log the gyro faster, or turn it with gentler ramps",
      corners.interval_s(), corners.largest_deg());
}

}  // namespace gyrobench::calibration
