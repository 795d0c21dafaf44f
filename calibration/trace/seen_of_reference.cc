#include "calibration/trace/seen_of_reference.h"

#include <cmath>
#include <utility>

#include "calibration/trace/candidate.h"
#include "calibration/trace/channel_fit.h"
#include "calibration/trace/channel_report.h"
#include "calibration/trace/channel_search.h"
#include "calibration/trace/problem.h"

namespace gyrobench::calibration {
namespace {

// Of -2 log L.
constexpr double kFelt = 10.0;

// The largest difference of all delays at the ends of the measurements [s].
double Apart_s(const ChannelRequest& request, const SeenOfReference* a, const SeenOfReference* b) {
  double apart_s = 0.0;
  for (const StateHistory& history : request.histories) {
    if (history.nodes.empty()) continue;
    for (const double t_s : {history.nodes.front().t_s, history.nodes.back().t_s}) {
      const double of_a = a == nullptr ? 0.0 : SumOf(a->delays, t_s);
      const double of_b = b == nullptr ? 0.0 : SumOf(b->delays, t_s);
      apart_s = std::max(apart_s, std::fabs(of_a - of_b));
    }
  }
  return apart_s;
}

// What the difference brings or costs of -2 log L, as the cross-axis part is, by the noise that the
// gyro alone has.
double GainOf(const ChannelRequest& request, const TracedChannel& traced, std::size_t axis,
              const SeenOfReference* before, const SeenOfReference* now) {
  const auto row = static_cast<Eigen::Index>(axis);
  const double part = traced.row.fitted ? traced.row.values(row) : kMissing;
  const double walk = traced.trace.noise.angle_random_walk_deg_sqrt_s;
  if (!std::isfinite(part) || !(walk > 0.0)) return 0.0;
  double sum = 0.0;
  for (std::size_t h = 0; h < request.histories.size(); ++h) {
    const std::vector<SensorState>& nodes = request.histories[h].nodes;
    for (std::size_t i = 0; i + 1 < nodes.size(); ++i) {
      const double was_deg = before == nullptr ? 0.0 : before->more_deg[h][i];
      const double is_deg = now == nullptr ? 0.0 : now->more_deg[h][i];
      const double length_s = nodes[i + 1].t_s - nodes[i].t_s;
      if (length_s > 0.0) sum += std::pow(part * (is_deg - was_deg) / walk, 2) / length_s;
    }
  }
  return sum;
}

}  // namespace

std::shared_ptr<const SeenOfReference> WhatIsSeenOfReference(const ChannelProblem& problem,
                                                             const std::vector<Candidate>& members,
                                                             const ChannelFit& fit) {
  if ((problem.observables() & kNeedsRate) == 0) return nullptr;
  auto out = std::make_shared<SeenOfReference>();
  Eigen::VectorXd more_deg = Eigen::VectorXd::Zero(problem.rows());
  for (std::size_t i = 0; i < members.size(); ++i) {
    const Candidate& member = members[i];
    if (member.effect == nullptr || member.effect->domain != EffectDomain::kAngle) continue;
    const auto count = static_cast<Eigen::Index>(member.columns.size());
    const auto values = fit.values.segment(fit.member_begin[i], count);
    more_deg += fit.raw.middleCols(fit.column_begin[i], count) * values;
    out->ids.push_back(member.id);
    if (member.effect->delay_s != nullptr)
      out->delays.push_back({member.effect->delay_s, values(0)});
  }
  if (out->ids.empty()) return nullptr;
  for (const StateHistory& history : problem.histories())
    out->more_deg.emplace_back(history.still.size(), 0.0);
  for (Eigen::Index i = 0; i < problem.rows(); ++i) {
    const ProblemRow& row = problem.row_refs()[static_cast<std::size_t>(i)];
    out->more_deg[row.history][row.interval] = more_deg(i);
  }
  return out;
}

bool IsFelt(const ChannelRequest& request, const TracedChannel& traced, const SeenOfAxes& now) {
  for (std::size_t axis = 0; axis < now.size(); ++axis) {
    const SeenOfReference *before = request.seen[axis].get(), *after = now[axis].get();
    const bool felt = axis == request.channel
                          ? request.histories.front().recording->info.gyro_delay_s > 0.0 &&
                                Apart_s(request, before, after) > kLongDelay_s
                          : GainOf(request, traced, axis, before, after) > kFelt;
    if (felt) return true;
  }
  return false;
}

}  // namespace gyrobench::calibration
