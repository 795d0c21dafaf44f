#include "calibration/trace/timing_noise.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <optional>
#include <utility>
#include <vector>

#include "calibration/gls/noise_search.h"
#include "calibration/state/timing_error.h"
#include "calibration/trace/candidate.h"
#include "calibration/trace/corners.h"
#include "calibration/trace/noise_share.h"
#include "calibration/trace/problem.h"

namespace gyrobench::calibration {
namespace {

// Of each measurement [s]. Where one does not show it clearly, as much as those that do, as of one
// logger, but no more than it may be there; 0 where none does.
std::vector<double> TimingErrors(const ChannelProblem& problem) {
  double square = 0.0, clear = 0.0;
  for (const StateHistory& history : problem.histories()) {
    if (!(history.timing_error_s > 0.0)) continue;
    square += history.timing_error_s * history.timing_error_s;
    clear += 1.0;
  }
  const double others_s = clear > 0.0 ? std::sqrt(square / clear) : 0.0;
  std::vector<double> out;
  for (const StateHistory& history : problem.histories()) {
    out.push_back(history.timing_error_s > 0.0 ? history.timing_error_s
                                               : std::fmin(others_s, history.timing_at_most_s));
  }
  return out;
}

// Of the axis that turns fastest at a node; of an orientation all readings are of all axes.
double ReadingsAt(const StateHistory& history, std::size_t node) {
  std::size_t fastest = 0;
  const Vector3& rates = history.nodes[node].table_rate_deg_s;
  for (std::size_t a = 1; a < 3; ++a) {
    if (std::fabs(rates[a]) > std::fabs(rates[fastest])) fastest = a;
  }
  return ReadingsBehind(history.epochs[node], fastest);
}

// What the times of the readings add to the noise of the nodes.
class TimingNoise {
 public:
  TimingNoise(const ChannelProblem& problem, std::vector<double> timing_s)
      : problem_(problem),
        timing_s_(std::move(timing_s)),
        walk_deg2_s_(RoughWalk_deg2_s(problem)) {}

  // Standard deviation of the times with a share, beside a noise [s].
  double Timing_s(const NoiseShare& found) const {
    return std::ranges::max(timing_s_) * std::sqrt(found.share / walk_deg2_s_) *
           found.noise->angle_random_walk_deg_sqrt_s;
  }
  // The gyro's random walk, to which it is compared, cannot be told.
  bool empty() const { return !(walk_deg2_s_ > 0.0); }

  // The rows with a share of the variances that the histories show.
  std::vector<Interval> With(double share) const {
    std::vector<Interval> out = problem_.intervals();
    const auto still = [&](std::size_t row) { return row >= out.size() || out[row].still; };
    for (std::size_t i = 0; i < out.size(); ++i) {
      if (out[i].still) continue;
      const std::uint32_t interval = problem_.row_refs()[i].interval;
      // The angle of a rest is that of all its readings.
      if (!still(i + 1) || !out[i + 1].GoesOn())
        out[i].end_reference_walk_s -= share * Walk_s(i, interval + 1);
      if (out[i].begins_with_new_error())
        out[i].begin_reference_walk_s -= share * Walk_s(i, interval);
    }
    return out;
  }

 private:
  // Variance of the angle that the channel feels at a node, over that of its random walk [s].
  double Walk_s(std::size_t row, std::size_t node) const {
    const std::size_t number = problem_.row_refs()[row].history;
    const StateHistory& history = problem_.histories()[number];
    const double rate_deg_s = history.nodes[node].rate_deg_s[problem_.channel()];
    if (!std::isfinite(rate_deg_s)) return 0.0;
    return timing_s_[number] * timing_s_[number] *
           VariancePerTiming(rate_deg_s, ReadingsAt(history, node)) / walk_deg2_s_;
  }

  const ChannelProblem& problem_;
  std::vector<double> timing_s_;
  double walk_deg2_s_ = 0.0;
};

}  // namespace

std::string AddTimingNoise(const Baseline& baseline, const CandidateSet& candidates,
                           ChannelProblem* problem) {
  constexpr double kLeastGain = 10.0;
  const bool turns = !baseline.turned.empty() && baseline.turned.front() == problem->channel();
  std::vector<double> timing_s = TimingErrors(*problem);
  if (!turns || !(std::ranges::max(timing_s) > 0.0)) return "";
  const TimingNoise timing(*problem, std::move(timing_s));
  if (timing.empty()) return "";
  const std::vector<RawColumns> columns = EverythingThatMayAct(baseline, candidates);
  const std::optional<NoiseEstimate> none =
      NoiseSearch(problem->intervals(), columns, problem->output_deg(), kNearlyDependent)
          .BestPlausible();
  if (!none) return "";
  const NoiseShare best = BestShare([&](double share) { return timing.With(share); }, columns,
                                    problem->output_deg(), none->noise, kLeastGain);
  if (best.share == 0.0) return "";
  problem->SetIntervals(timing.With(best.share));
  return fmt::format(
      "the angle of the reference errs by more the faster it turns, as if the times of its "
      "readings were wrong by {:.1f} ms (standard deviation). A computer that stamps rows when it "
      "gets to them does this. The stated errors include it. To see smaller effects, log the times "
      "at which the sensors themselves measured",
      1e3 * timing.Timing_s(best));
}

}  // namespace gyrobench::calibration
