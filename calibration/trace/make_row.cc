#include <fmt/format.h>

#include <algorithm>
#include <string>
#include <vector>

#include "calibration/trace/channel_fit.h"
#include "calibration/trace/report_parts.h"
#include "calibration/trace/selection.h"

namespace gyrobench::calibration {
namespace {

constexpr Eigen::Index kNotThere = -1;

// What the channels feel alike: errors of the angle that bench or reference make, where no part of
// them was searched for and none is of one measurement alone, nor differs in one of them.
bool IsShared(const Candidate& member, const std::vector<Candidate>& members) {
  const Effect* effect = member.effect;
  if (effect == nullptr || effect->domain != EffectDomain::kAngle ||
      effect->owner == EffectOwner::kGyro || member.of_one_run())
    return false;
  const bool differs = std::ranges::any_of(members, [&](const Candidate& other) {
    return other.effect != nullptr && other.effect->differs_in_one_run == effect->id;
  });
  return !differs && !member.power_on && !member.searched();
}

// The same for all channels that found it.
std::string NameOf(const Candidate& member) {
  const bool placed = member.search() != Search::kCoefficient && !member.context.nonlinear.empty();
  return placed ? fmt::format("{}@{:.4g}", member.family, member.context.nonlinear[0])
                : member.family;
}

}  // namespace

ChannelRow MakeChannelRow(const ChannelProblem& problem, const Baseline& baseline,
                          const Selection& selection, const ChannelFit& fit, double grow) {
  ChannelRow row;
  row.channel = problem.channel();
  // Where each of the row's values is among the fit's.
  std::vector<Eigen::Index> from(3, kNotThere);
  for (std::size_t j = 0; j < baseline.turned.size(); ++j)
    from[baseline.turned[j]] = static_cast<Eigen::Index>(j);
  for (std::size_t i = 0; i < selection.members().size(); ++i) {
    const Candidate& member = selection.members()[i];
    if (!IsShared(member, selection.members())) continue;
    for (std::size_t k = 0; k < member.effect->terms.size(); ++k) {
      const EffectTerm& term = member.effect->terms[k];
      from.push_back(fit.member_begin[i] + static_cast<Eigen::Index>(k));
      row.shared.push_back({NameOf(member) + "." + term.name, term.unit});
    }
  }
  const auto count = static_cast<Eigen::Index>(from.size());
  row.values = Eigen::VectorXd::Constant(count, kMissing);
  row.covariance = Eigen::MatrixXd::Constant(count, count, kMissing);
  for (Eigen::Index i = 0; i < count; ++i) {
    const Eigen::Index at = from[static_cast<std::size_t>(i)];
    if (at == kNotThere) continue;
    row.values(i) = fit.values(at);
    for (Eigen::Index j = 0; j < count; ++j) {
      const Eigen::Index other = from[static_cast<std::size_t>(j)];
      if (other != kNotThere) row.covariance(i, j) = grow * grow * fit.covariance(at, other);
    }
  }
  row.by_common = Eigen::MatrixXd::Zero(count, fit.by_misread.cols());
  for (Eigen::Index i = 0; i < count; ++i) {
    const Eigen::Index at = from[static_cast<std::size_t>(i)];
    if (at != kNotThere) row.by_common.row(i) = grow * fit.by_misread.row(at);
  }
  row.common = problem.NamesOfMisreadDeviations();
  row.gravity = FitGravityRow(problem, selection, fit, grow);
  row.fitted = true;
  return row;
}

}  // namespace gyrobench::calibration
