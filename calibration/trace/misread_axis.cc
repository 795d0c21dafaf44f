#include "calibration/trace/misread_axis.h"

#include <algorithm>
#include <cmath>

#include "calibration/trace/candidate.h"
#include "calibration/trace/channel_fit.h"
#include "calibration/trace/channel_report.h"
#include "calibration/trace/channel_search.h"
#include "calibration/trace/problem.h"

namespace gyrobench::calibration {
namespace {

bool KnowsAllTerms(const MisreadAxis& found) {
  return found.covariance.allFinite() && (found.covariance.diagonal().array() > 0.0).all();
}

bool IsSure(const MisreadAxis& found) {
  constexpr double kStandardErrors = 3.0;
  return found.values.norm() >
         kStandardErrors *
             std::sqrt(found.covariance.trace() / static_cast<double>(found.values.size()));
}

bool NamesItself(const TracedChannel& traced, const MisreadAxis& found) {
  return std::ranges::any_of(traced.bench_findings.found,
                             [&](const BenchFinding& own) { return found.Is(own); });
}

// By how much -2 log L changes, at the most, with what the axis turns the directions of others'
// motions by: by the angle random walk alone.
double MostChange(const ChannelRequest& request, const TracedChannel& traced,
                  const MisreadAxis& axis) {
  const double walk = traced.trace.noise.angle_random_walk_deg_sqrt_s;
  if (!(walk > 0.0)) return 0.0;
  double sum = 0.0;
  for (const StateHistory& history : request.histories) {
    for (std::size_t i = 0; i < history.still.size(); ++i) {
      const double length_s = history.nodes[i + 1].t_s - history.nodes[i].t_s;
      if (history.still[i] || !history.usable[i][request.channel] || !(length_s > 0.0)) continue;
      const FeltAxis felt = FeelAxes(history, i, request.channel)[axis.context.table_axis];
      const double most = felt.direction * axis.values.norm() / walk;
      if (std::isfinite(most)) sum += most * most / length_s;
    }
  }
  return sum;
}

}  // namespace

bool MisreadAxis::Is(const BenchFinding& found) const {
  return found.effect == effect && found.table_axis == context.table_axis &&
         found.nonlinear == context.nonlinear;
}

std::vector<MisreadAxis> MisreadAxesOf(const ChannelProblem& problem,
                                       const std::vector<Candidate>& members,
                                       const ChannelFit& fit) {
  std::vector<MisreadAxis> out;
  const double grow = std::max(1.0, fit.whitened_rms());
  for (std::size_t i = 0; i < members.size(); ++i) {
    const Candidate& member = members[i];
    if (member.effect == nullptr || !member.effect->wave_of_angle) continue;
    const bool turns = std::ranges::find(problem.table_axes(), member.context.table_axis) !=
                       problem.table_axes().end();
    const Eigen::Index at = fit.member_begin[i];
    const auto count = static_cast<Eigen::Index>(member.columns.size());
    MisreadAxis found{member.effect, member.context, fit.values.segment(at, count),
                      grow * grow * fit.covariance.block(at, at, count, count)};
    if (turns && KnowsAllTerms(found)) out.push_back(std::move(found));
  }
  return out;
}

std::vector<MisreadAxis> MisreadByOthers(std::span<const ChannelRequest> requests,
                                         std::span<const TracedChannel> traced, std::size_t k) {
  constexpr double kSeen = 10.0;  // of -2 log L
  std::vector<MisreadAxis> out;
  for (std::size_t other = 0; other < traced.size(); ++other) {
    if (other == k) continue;
    for (const MisreadAxis& found : traced[other].misread) {
      if (!IsSure(found) || NamesItself(traced[k], found) ||
          !(MostChange(requests[k], traced[k], found) > kSeen))
        continue;
      const auto same =
          std::ranges::find_if(out, [&](const MisreadAxis& axis) { return axis.SameAs(found); });
      if (same == out.end()) {
        out.push_back(found);
      } else if (found.covariance.trace() < same->covariance.trace()) {
        *same = found;
      }
    }
  }
  return out;
}

bool AreTheSame(std::span<const MisreadAxis> some, std::span<const MisreadAxis> others) {
  return std::ranges::equal(some, others,
                            [](const MisreadAxis& a, const MisreadAxis& b) { return a.SameAs(b); });
}

}  // namespace gyrobench::calibration
