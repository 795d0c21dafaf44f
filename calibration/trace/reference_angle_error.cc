#include "calibration/trace/reference_angle_error.h"

#include <algorithm>
#include <cmath>

#include "calibration/trace/candidate.h"
#include "calibration/trace/channel_fit.h"
#include "calibration/trace/channel_report.h"
#include "calibration/trace/channel_search.h"
#include "calibration/trace/problem.h"

namespace gyrobench::calibration {
namespace {

constexpr double kSeen = 10.0;  // of -2 log L

std::vector<Delay> DelaysOf(const ReferenceAngleError* error) {
  return error == nullptr ? std::vector<Delay>() : error->delays;
}

// By how much -2 log L changes, at the most, where the turn about another axis changes from
// `before` to `now`: by the cross-axis part as it was fitted, and the angle random walk alone.
double MostChange(const ChannelRequest& request, const TracedChannel& traced, std::size_t axis,
                  const ReferenceAngleError* before, const ReferenceAngleError* now) {
  const auto column = static_cast<Eigen::Index>(axis);
  const double part = traced.row.fitted ? traced.row.values(column) : kMissing;
  const double walk = traced.trace.noise.angle_random_walk_deg_sqrt_s;
  if (!std::isfinite(part) || !(walk > 0.0)) return 0.0;
  double sum = 0.0;
  for (std::size_t h = 0; h < request.histories.size(); ++h) {
    const std::vector<SensorState>& nodes = request.histories[h].nodes;
    for (std::size_t i = 0; i + 1 < nodes.size(); ++i) {
      const double was_deg = before == nullptr ? 0.0 : before->turn_beyond_deg[h][i];
      const double is_deg = now == nullptr ? 0.0 : now->turn_beyond_deg[h][i];
      const double length_s = nodes[i + 1].t_s - nodes[i].t_s;
      if (length_s > 0.0) sum += std::pow(part * (is_deg - was_deg) / walk, 2) / length_s;
    }
  }
  return sum;
}

// Delays are straight lines of the time: they are largest where a measurement begins or ends.
template <typename DelayAt>
double LongestAtAnEnd_s(std::span<const StateHistory> histories, const DelayAt& delay_s) {
  double longest_s = 0.0;
  for (const StateHistory& history : histories) {
    if (history.nodes.empty()) continue;
    for (const SensorState* node : {&history.nodes.front(), &history.nodes.back()})
      longest_s = std::max(longest_s, std::fabs(delay_s(*node)));
  }
  return longest_s;
}

}  // namespace

std::shared_ptr<const ReferenceAngleError> ReferenceAngleErrorOf(
    const ChannelProblem& problem, const std::vector<Candidate>& members, const ChannelFit& fit) {
  if ((problem.observables() & kNeedsRate) == 0) return nullptr;
  auto out = std::make_shared<ReferenceAngleError>();
  Eigen::VectorXd turn_beyond_deg = Eigen::VectorXd::Zero(problem.rows());
  bool any = false;
  for (std::size_t i = 0; i < members.size(); ++i) {
    const Candidate& member = members[i];
    if (member.effect == nullptr || member.effect->domain != EffectDomain::kAngle) continue;
    const auto count = static_cast<Eigen::Index>(member.columns.size());
    const auto values = fit.values.segment(fit.member_begin[i], count);
    turn_beyond_deg += fit.raw.middleCols(fit.column_begin[i], count) * values;
    any = true;
    if (member.effect->delay_s != nullptr)
      out->delays.push_back({member.effect->delay_s, values(0)});
  }
  if (!any || !turn_beyond_deg.allFinite()) return nullptr;
  // Others have the turns by the corrected readings: that they must not take off once more.
  if (problem.corrected_drift_ppm() != 0.0) turn_beyond_deg += problem.DriftCorrection_deg();
  for (const StateHistory& history : problem.histories())
    out->turn_beyond_deg.emplace_back(history.still.size(), 0.0);
  for (Eigen::Index i = 0; i < problem.rows(); ++i) {
    const ProblemRow& row = problem.row_refs()[static_cast<std::size_t>(i)];
    out->turn_beyond_deg[row.history][row.interval] = turn_beyond_deg(i);
  }
  return out;
}

bool NeedsRetrace(const ChannelRequest& request, const TracedChannel& traced,
                  const ReferenceAngleErrors& now) {
  for (std::size_t axis = 0; axis < now.size(); ++axis) {
    const ReferenceAngleError* before = request.angle_errors[axis].get();
    const bool seen = axis == request.channel
                          ? GyroDelayIsDeclared(request.histories) &&
                                DelaysApart_s(request.histories, DelaysOf(before),
                                              DelaysOf(now[axis].get())) > kLongDelay_s
                          : MostChange(request, traced, axis, before, now[axis].get()) > kSeen;
    if (seen) return true;
  }
  return false;
}

double DelayLeft_s(const std::vector<Delay>& delays, const SensorState& node) {
  return delays.empty() ? 0.0 : TotalDelay_s(delays, node.stamp_s()) - node.drift_correction_s;
}

double LongestDelay_s(std::span<const StateHistory> histories, const std::vector<Delay>& delays) {
  return LongestAtAnEnd_s(
      histories, [&](const SensorState& node) { return TotalDelay_s(delays, node.stamp_s()); });
}

double LongestDelayLeft_s(std::span<const StateHistory> histories,
                          const std::vector<Delay>& delays) {
  return LongestAtAnEnd_s(histories,
                          [&](const SensorState& node) { return DelayLeft_s(delays, node); });
}

double DelaysApart_s(std::span<const StateHistory> histories, const std::vector<Delay>& a,
                     const std::vector<Delay>& b) {
  return LongestAtAnEnd_s(histories, [&](const SensorState& node) {
    return DelayLeft_s(a, node) - DelayLeft_s(b, node);
  });
}

}  // namespace gyrobench::calibration
