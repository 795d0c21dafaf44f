#include "calibration/trace/angle_error.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace gyrobench::calibration {
namespace {

std::optional<std::size_t> PowerOnOf(const ChannelProblem& problem, std::size_t number) {
  for (std::size_t k = 0; k < problem.power_on_begins().size(); ++k) {
    if (problem.first_number(k) == number) return k;
  }
  return std::nullopt;
}

bool IsPlaced(const AngleError& error) {
  return error.effect->search == Search::kTime || error.effect->search == Search::kPeriods;
}

// A scan of another channel places the same thing a little elsewhere.
bool AreOne(const AngleError& a, const AngleError& b) {
  constexpr double kSameTime_s = 1.0, kSamePeriods = 1.0;
  if (a.effect != b.effect || a.table_axis != b.table_axis || a.power_on != b.power_on)
    return false;
  if (!IsPlaced(a)) return true;
  const double same = a.effect->search == Search::kTime ? kSameTime_s : kSamePeriods;
  return std::fabs(a.nonlinear.front() - b.nonlinear.front()) < same;
}

bool IsAmong(const std::vector<AngleError>& errors, const AngleError& error) {
  return std::ranges::any_of(errors, [&](const AngleError& one) { return AreOne(one, error); });
}

// Terms that the channel is blind to are 0 and have no variance.
double LargestSize(const ChannelFit& fit, Eigen::Index first, std::size_t count) {
  constexpr double kSure = 4.0;  // standard errors
  double size2 = 0.0, variance = 0.0;
  for (Eigen::Index j = first; j < first + static_cast<Eigen::Index>(count); ++j) {
    if (!(fit.covariance(j, j) > 0.0)) continue;
    size2 += fit.values(j) * fit.values(j);
    variance += fit.covariance(j, j);
  }
  return std::sqrt(size2) + kSure * std::sqrt(variance);
}

bool Contains(const std::vector<std::size_t>& axes, std::size_t axis) {
  return std::ranges::find(axes, axis) != axes.end();
}

}  // namespace

AngleErrors AngleErrorsOf(const ChannelProblem& problem, const std::vector<Candidate>& members,
                          const ChannelFit& fit) {
  AngleErrors errors;
  errors.turning = problem.table_axes();
  errors.felt = problem.axes_with_felt_errors();
  for (std::size_t i = 0; i < members.size(); ++i) {
    const Candidate& member = members[i];
    if (member.effect == nullptr || (member.effect->needs & kNeedsTableAxis) == 0) continue;
    AngleError error{member.effect, member.context.table_axis, member.context.nonlinear, {}};
    if (member.power_on) error.power_on = problem.first_number(*member.power_on);
    error.largest = LargestSize(fit, fit.member_begin[i], member.columns.size());
    errors.found.push_back(std::move(error));
  }
  return errors;
}

AngleErrors Without(AngleErrors own, const std::vector<AngleError>& told) {
  std::erase_if(own.found, [&](const AngleError& error) { return IsAmong(told, error); });
  return own;
}

bool NamesWhatIsGone(const AngleErrors& named, const std::vector<AngleError>& before,
                     const std::vector<AngleError>& now) {
  return std::ranges::any_of(named.found, [&](const AngleError& error) {
    return IsAmong(before, error) && !IsAmong(now, error);
  });
}

std::vector<AngleError> NewTo(const AngleErrors& own, const std::vector<AngleError>& found) {
  std::vector<AngleError> out;
  for (AngleError error : found) {
    const std::size_t found_on = error.table_axis;
    const double found_largest = error.largest;
    for (const std::size_t axis : own.felt) {
      const bool turns = Contains(own.turning, axis);
      if (axis != found_on && (!turns || error.effect->search != Search::kPeriods)) continue;
      if (!IsPlaced(error) && turns) continue;
      error.table_axis = axis;
      // Another axis of the same make has as many periods a turn, and an amplitude of its own.
      error.largest = axis == found_on ? found_largest : std::numeric_limits<double>::infinity();
      if (!IsAmong(own.found, error) && !IsAmong(out, error)) out.push_back(error);
    }
  }
  return out;
}

std::vector<Candidate> CandidatesOf(const ChannelProblem& problem,
                                    std::span<const AngleError> errors) {
  std::vector<Candidate> out;
  for (const AngleError& error : errors) {
    std::optional<std::size_t> power_on;
    if (error.power_on) {
      power_on = PowerOnOf(problem, *error.power_on);
      if (!power_on) continue;
    }
    out.push_back(
        PlacedCandidate(problem, *error.effect, error.table_axis, error.nonlinear, power_on));
    out.back().largest = error.largest;
  }
  return out;
}

}  // namespace gyrobench::calibration
