#include "calibration/trace/retrace.h"

#include <cmath>
#include <utility>

#include "calibration/trace/candidate.h"
#include "calibration/trace/channel_fit.h"
#include "calibration/trace/channel_report.h"
#include "calibration/trace/channel_search.h"
#include "calibration/trace/problem.h"

namespace gyrobench::calibration {
namespace {

constexpr double kSeen = 10.0;  // of -2 log L

// The longest difference of the delays of two errors of one axis [s].
double DelaysApart_s(const ChannelRequest& request, const ReferenceAngleError* a,
                     const ReferenceAngleError* b) {
  std::vector<Delay> apart;
  if (a != nullptr) apart = a->delays;
  if (b != nullptr) {
    for (const Delay& delay : b->delays) apart.push_back({delay.delay_s, -delay.coefficient});
  }
  return LongestDelay_s(request.histories, apart);
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
                                DelaysApart_s(request, before, now[axis].get()) > kLongDelay_s
                          : MostChange(request, traced, axis, before, now[axis].get()) > kSeen;
    if (seen) return true;
  }
  return false;
}

}  // namespace gyrobench::calibration
