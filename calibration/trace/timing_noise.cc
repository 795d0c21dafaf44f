#include "calibration/trace/timing_noise.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <optional>
#include <vector>

#include "calibration/trace/candidate.h"
#include "calibration/trace/noise_share.h"
#include "calibration/trace/problem.h"

namespace gyrobench::calibration {
namespace {

// Square of what the angle at a node is off by where each of its readings is off by 1 s [deg^2].
double PerSquareSecond(const StateHistory& history, std::size_t node, std::size_t channel) {
  const double rate_deg_s = history.nodes[node].rate_deg_s[channel];
  if (!std::isfinite(rate_deg_s)) return 0.0;
  return rate_deg_s * rate_deg_s / std::max(1.0, history.epochs[node].mean.readings);
}

class TimingNoise {
 public:
  explicit TimingNoise(const ChannelProblem& problem) : problem_(problem) {
    double sum = 0.0, duration_s = 0.0;
    for (Eigen::Index i = 0; i < problem.rows(); ++i) {
      const Interval& interval = problem.intervals()[static_cast<std::size_t>(i)];
      if (interval.still) continue;
      const ProblemRow& row = problem.row_refs()[static_cast<std::size_t>(i)];
      sum += PerSquareSecond(problem.history(i), row.interval + 1, problem.channel());
      duration_s += interval.duration_s;
    }
    if (sum > 0.0) unit_s3_ = duration_s / sum;
  }
  bool empty() const { return unit_s3_ == 0.0; }

  // With a share of 1 the angle at a mean node is off by what the gyro's random walk does from one
  // node to the next.
  std::vector<Interval> With(double share) const {
    std::vector<Interval> out = problem_.intervals();
    for (std::size_t i = 0; i < out.size(); ++i) {
      if (out[i].still) continue;
      const ProblemRow& row = problem_.row_refs()[i];
      const StateHistory& history = problem_.histories()[row.history];
      const auto walk_s = [&](std::size_t node) {
        return share * unit_s3_ * PerSquareSecond(history, node, problem_.channel());
      };
      out[i].end_reference_walk_s -= walk_s(row.interval + 1);
      out[i].begin_reference_walk_s -= walk_s(row.interval);
    }
    return out;
  }
  // Standard deviation of the time of a reading.
  double Error_s(double share, double angle_random_walk_deg_sqrt_s) const {
    return angle_random_walk_deg_sqrt_s * std::sqrt(share * unit_s3_);
  }

 private:
  const ChannelProblem& problem_;
  double unit_s3_ = 0.0;  // 1 s^2 of the times for 1 deg^2/s of the gyro's walk
};

}  // namespace

std::string AddTimingNoise(const Baseline& baseline, const CandidateSet& candidates,
                           ChannelProblem* problem) {
  constexpr double kMost = 4096.0;
  const bool seen = std::ranges::any_of(problem->histories(), [](const StateHistory& history) {
    return history.timing_error_s > 0.0;
  });
  if (!seen) return "";
  const TimingNoise timing(*problem);
  if (timing.empty()) return "";
  const std::vector<RawColumns> columns = EverythingThatMayAct(baseline, candidates);
  const NoiseShare best = BestShare([&](double share) { return timing.With(share); }, columns,
                                    problem->output_deg(), {}, kMost);
  if (best.share == 0.0) return "";
  problem->SetIntervals(timing.With(best.share));
  return fmt::format(
      "the angle errs by more the faster it turns, as if the times of its readings were off by "
      "{:.2g} ms: stamps that are given by a computer are late by what else it does; the errors "
      "allow for that, and smaller effects are seen where the units that measure give the times",
      1e3 * timing.Error_s(best.share, best.noise->angle_random_walk_deg_sqrt_s));
}

}  // namespace gyrobench::calibration
