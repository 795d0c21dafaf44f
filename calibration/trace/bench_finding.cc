#include "calibration/trace/bench_finding.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <utility>

#include "calibration/trace/candidate.h"
#include "calibration/trace/channel_fit.h"

namespace gyrobench::calibration {
namespace {

std::optional<std::size_t> PowerOnOf(const ChannelProblem& problem, std::size_t number) {
  for (std::size_t k = 0; k < problem.power_on_begins().size(); ++k) {
    if (problem.first_number(k) == number) return k;
  }
  return std::nullopt;
}

bool IsPlaced(const BenchFinding& error) {
  return error.effect->search == Search::kTime || error.effect->search == Search::kPeriods;
}

// A scan of another channel places the same thing a little elsewhere.
bool AreOne(const BenchFinding& a, const BenchFinding& b) {
  constexpr double kSameTime_s = 1.0, kSamePeriods = 1.0;
  if (a.of_stand || b.of_stand) return a.of_stand && b.of_stand && a.effect == b.effect;
  if (a.effect != b.effect || a.table_axis != b.table_axis || a.power_on != b.power_on)
    return false;
  if (!IsPlaced(a)) return true;
  const double same = a.effect->search == Search::kTime ? kSameTime_s : kSamePeriods;
  return std::fabs(a.nonlinear.front() - b.nonlinear.front()) < same;
}

bool IsAmong(const std::vector<BenchFinding>& errors, const BenchFinding& error) {
  return std::ranges::any_of(errors, [&](const BenchFinding& one) { return AreOne(one, error); });
}

// Terms that the channel is blind to have no variance, and may be of any size.
double LargestSize(const ChannelFit& fit, Eigen::Index first, std::size_t count) {
  constexpr double kSure = 4.0;  // standard errors
  double size2 = 0.0, variance = 0.0;
  for (Eigen::Index j = first; j < first + static_cast<Eigen::Index>(count); ++j) {
    if (!(fit.covariance(j, j) > 0.0)) return std::numeric_limits<double>::infinity();
    size2 += fit.values(j) * fit.values(j);
    variance += fit.covariance(j, j);
  }
  return std::sqrt(size2) + kSure * std::max(1.0, fit.whitened_rms()) * std::sqrt(variance);
}

bool SeveralAxesTurn(const ChannelProblem& problem) {
  constexpr double kTurns_deg_s = 1.0;
  std::array<bool, 3> turns = {};
  for (Eigen::Index i = 0; i < problem.rows(); ++i) {
    for (std::size_t a = 0; a < 3; ++a)
      turns[a] = turns[a] || std::fabs(problem.half(i, 0).table_rate_deg_s[a]) > kTurns_deg_s;
  }
  return std::ranges::count(turns, true) > 1;
}

bool Contains(const std::vector<std::size_t>& axes, std::size_t axis) {
  return std::ranges::find(axes, axis) != axes.end();
}

}  // namespace

BenchFindings FindingsOf(const ChannelProblem& problem, const std::vector<Candidate>& members,
                         const ChannelFit& fit) {
  BenchFindings errors;
  errors.turning = problem.table_axes();
  errors.felt = problem.axes_with_felt_errors();
  for (std::size_t i = 0; i < members.size(); ++i) {
    const Candidate& member = members[i];
    if (member.effect == nullptr) continue;
    const bool shakes = member.effect->shakes_stand && SeveralAxesTurn(problem);
    if (!shakes && (member.effect->needs & kNeedsTableAxis) == 0) continue;
    BenchFinding error{member.effect, member.context.table_axis, member.context.nonlinear, {}};
    if (shakes) {
      error.of_stand = true;
      (member.context.of_stand ? errors.found : errors.supposed).push_back(std::move(error));
      continue;
    }
    if (member.effect->of_one_time())
      error.power_on = problem.first_number(member.power_on.value_or(0));
    error.largest = LargestSize(fit, fit.member_begin[i], member.columns.size());
    errors.found.push_back(std::move(error));
  }
  return errors;
}

BenchFindings Without(BenchFindings own, const std::vector<BenchFinding>& told) {
  std::erase_if(own.found,
                [&](const BenchFinding& error) { return !error.of_stand && IsAmong(told, error); });
  return own;
}

bool NamesWhatIsGone(const BenchFindings& named, const std::vector<BenchFinding>& before,
                     const std::vector<BenchFinding>& now) {
  return std::ranges::any_of(named.found, [&](const BenchFinding& error) {
    return !error.of_stand && IsAmong(before, error) && !IsAmong(now, error);
  });
}

std::vector<BenchFinding> NewTo(const BenchFindings& own, const std::vector<BenchFinding>& found) {
  std::vector<BenchFinding> out;
  auto tell = [&](const BenchFinding& error) {
    if (IsAmong(own.found, error)) return;
    const auto told =
        std::ranges::find_if(out, [&](const BenchFinding& one) { return AreOne(one, error); });
    if (told == out.end()) {
      out.push_back(error);
    } else {
      told->largest = std::min(told->largest, error.largest);
    }
  };
  for (BenchFinding error : found) {
    if (error.of_stand) {
      tell(error);
      continue;
    }
    const std::size_t found_on = error.table_axis;
    const double found_largest = error.largest;
    for (const std::size_t axis : own.felt) {
      const bool turns = Contains(own.turning, axis);
      if (axis != found_on && (!turns || error.effect->search != Search::kPeriods)) continue;
      if (!IsPlaced(error) && turns) continue;
      error.table_axis = axis;
      // Another axis of the same make has as many periods a turn, and an amplitude of its own.
      error.largest = axis == found_on ? found_largest : std::numeric_limits<double>::infinity();
      tell(error);
    }
  }
  return out;
}

std::vector<Candidate> CandidatesOf(const ChannelProblem& problem,
                                    std::span<const BenchFinding> errors) {
  std::vector<Candidate> out;
  for (const BenchFinding& error : errors) {
    std::optional<std::size_t> power_on;
    if (error.power_on) {
      power_on = PowerOnOf(problem, *error.power_on);
      if (!power_on) continue;
      if (problem.power_on_begins().size() == 1) power_on.reset();
    }
    out.push_back(
        PlacedCandidate(problem, *error.effect, error.table_axis, error.nonlinear, power_on));
    out.back().largest = error.largest;
    out.back().context.of_stand = error.of_stand;
    if (error.of_stand) out.back().family += "_of_stand";
  }
  return out;
}

}  // namespace gyrobench::calibration
