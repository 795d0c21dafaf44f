// As much of what rounding makes of a steady rate as the data want, as jumps of the bias.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <vector>

#include "calibration/trace/candidate.h"
#include "calibration/trace/noise_share.h"
#include "calibration/trace/problem.h"
#include "calibration/trace/timing_noise.h"

namespace gyrobench::calibration {
namespace {

class RoundingNoise {
 public:
  explicit RoundingNoise(const ChannelProblem& problem) : problem_(problem) {
    const auto rows = static_cast<std::size_t>(problem.rows());
    jump_per_s_.assign(rows, 0.0);
    for (std::size_t i = 1; i < rows; ++i) {
      if (!problem.intervals()[i].new_run) jump_per_s_[i] = JumpPerS(i);
    }
  }

  bool empty() const {
    return std::ranges::all_of(jump_per_s_, [](double jump) { return jump == 0.0; });
  }

  std::vector<Interval> With(double share) const {
    std::vector<Interval> out = problem_.intervals();
    for (std::size_t i = 0; i < out.size(); ++i) out[i].bias_jump_per_s = share * jump_per_s_[i];
    return out;
  }

  // Standard deviation at a steady rate, under the noise that went with the share [deg/s].
  double Doubt_deg_s(const NoiseShare& found) const {
    return found.noise->angle_random_walk_deg_sqrt_s *
           std::sqrt(found.share * std::ranges::max(jump_per_s_));
  }

 private:
  const OutputRounding& RoundingOf(std::size_t row) const {
    return RecordingOf(row).rounding[problem_.channel()];
  }
  const Recording& RecordingOf(std::size_t row) const {
    return *problem_.history(static_cast<Eigen::Index>(row)).recording;
  }
  // Mean output.
  double Rate(std::size_t row) const {
    const std::vector<Node>& nodes = problem_.history(static_cast<Eigen::Index>(row)).epochs;
    const std::uint32_t interval = problem_.row_refs()[row].interval;
    const IntegralMark &from = nodes[interval].at, &to = nodes[interval + 1].at;
    const std::size_t c = problem_.channel();
    return (to.z[c] - from.z[c]) / (to.t_s - from.t_s);
  }

  // Of the wave as the samples' noise has it. Where the rate is another than in the row before; over
  // a ramp it averages. The white noise of such samples is scatter^2 times their interval.
  double JumpPerS(std::size_t row) const {
    constexpr double kOtherRate = 0.5;  // steps
    const OutputRounding& rounding = RoundingOf(row);
    if (!(rounding.wave > 0.0)) return 0.0;
    const double passed = std::fabs(Rate(row) - Rate(row - 1)) / rounding.step;
    if (!(passed > kOtherRate)) return 0.0;
    const double averaged = std::min(1.0, 1.0 / (std::numbers::pi * passed));
    return 0.5 * std::pow(rounding.wave * averaged / rounding.scatter, 2) /
           RecordingOf(row).median_interval_s;
  }

  const ChannelProblem& problem_;
  std::vector<double> jump_per_s_;  // variance of the bias over N^2, by each row's rounding
};

}  // namespace

std::string AddRoundingNoise(const Baseline& baseline, const CandidateSet& candidates,
                             ChannelProblem* problem) {
  constexpr double kLeastGain = 10.0;
  const RoundingNoise rounding(*problem);
  if (rounding.empty()) return "";
  const NoiseShare best =
      BestShare([&](double share) { return rounding.With(share); },
                EverythingThatMayAct(baseline, candidates), problem->output_deg(), {}, kLeastGain);
  if (best.share == 0.0) return "";
  problem->SetIntervals(rounding.With(best.share));
  return fmt::format(
      "the samples come in steps that their noise does not carry them over: at a steady rate their "
      "mean is off by up to a part of a step, {:.1g} deg/s (standard deviation). The stated errors "
      "include it. To see smaller effects, choose a smaller range of the sensor, or a wider band "
      "of its filter",
      rounding.Doubt_deg_s(best));
}

}  // namespace gyrobench::calibration
