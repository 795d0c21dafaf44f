// Delays add in time: each has the shape of all of them together.
#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <vector>

#include "calibration/gls/scaled_ldlt.h"
#include "calibration/trace/selection.h"

namespace gyrobench::calibration {
namespace {

Delay DelayOfMember(const Candidate& member) {
  return {member.effect->delay_s, member.context.nonlinear.front()};
}

bool IsDelay(const Candidate& candidate) {
  return candidate.effect != nullptr && candidate.effect->delay_s != nullptr;
}

double Longest_s(const ChannelProblem& problem, const std::vector<Delay>& delays) {
  double longest_s = 0.0;
  if (delays.empty()) return longest_s;
  for (Eigen::Index i = 0; i < problem.rows(); ++i)
    longest_s = std::max(longest_s, std::fabs(SumOf(delays, problem.end_s(i))));
  return longest_s;
}

// As far as a shape goes, which hardly changes with a hundredth of the delay.
bool Alike(const ChannelProblem& problem, const std::vector<Delay>& a,
           const std::vector<Delay>& b) {
  constexpr double kSame_s = 1e-4;
  if (a.empty() || b.empty()) return a.empty() == b.empty();
  std::vector<Delay> apart = a;
  for (const Delay& delay : b) apart.push_back({delay.delay_s, -delay.coefficient});
  return Longest_s(problem, apart) < kSame_s;
}

}  // namespace

// Of the members but one, and but the candidate's own family; none where they are short.
std::vector<Delay> Selection::DelaysBeside(const Candidate& candidate, std::size_t without) const {
  std::vector<Delay> delays;
  for (std::size_t i = 0; i < members_.size(); ++i) {
    if (i != without && IsDelay(members_[i]) && members_[i].family != candidate.family)
      delays.push_back(DelayOfMember(members_[i]));
  }
  return Longest_s(*problem_, delays) < kLongDelay_s ? std::vector<Delay>() : delays;
}

// Its columns come anew where the delays beside it are others than it was made for.
void Selection::SetDelaysBeside(std::size_t without, Candidate* candidate) const {
  if (candidate->effect == nullptr || !candidate->effect->of_delay()) return;
  std::vector<Delay> delays = DelaysBeside(*candidate, without);
  if (Alike(*problem_, delays, candidate->context.other_delays)) return;
  candidate->context.other_delays = std::move(delays);
  candidate->raw.reset();
  candidate->columns.clear();
}

// The coefficients of several delays, found together, until their shapes are those of their sum.
void Selection::SolveDelays(const std::vector<std::size_t>& delays) {
  constexpr int kRounds = 10;
  constexpr double kSame = 1e-6;  // of a range
  WhiteStore::Columns others = base_;
  for (std::size_t i = 0; i < members_.size(); ++i) {
    if (std::ranges::find(delays, i) == delays.end())
      others.insert(others.end(), members_[i].columns.begin(), members_[i].columns.end());
  }
  const Projection others_off(store_.Take(others));
  Eigen::MatrixXd of_output;
  const Eigen::VectorXd residual = others_off.Off(store_.output(), &of_output);
  Eigen::MatrixXd x(residual.size(), static_cast<Eigen::Index>(delays.size()));
  Eigen::VectorXd first(x.cols());
  double most = 1.0;
  for (int round = 0; round < kRounds && most > kSame; ++round) {
    for (Eigen::Index j = 0; j < x.cols(); ++j) {
      Candidate& member = members_[delays[static_cast<std::size_t>(j)]];
      member.context.other_delays = DelaysBeside(member, kNoMember);
      member.raw.reset();
      Eigen::MatrixXd of_column;
      x.col(j) = others_off.Off(White(member), &of_column).col(0);
      first(j) = of_column(0, 0);
    }
    const Eigen::VectorXd c = ScaledLdlt(x.transpose() * x).Solve(x.transpose() * residual);
    const double scale = ScaleFactorOr(of_output(0, 0) - first.dot(c));
    most = 0.0;
    for (Eigen::Index j = 0; j < x.cols(); ++j) {
      Candidate& member = members_[delays[static_cast<std::size_t>(j)]];
      const NonlinearParameter& range = member.effect->nonlinear.front();
      double& value = member.context.nonlinear.front();
      const double now = std::clamp(c(j) / scale, range.low, range.high);
      most = std::max(most, std::fabs(now - value) / (range.high - range.low));
      value = now;
    }
  }
}

// After each change of the model.
void Selection::AddDelaysInTime() {
  std::vector<std::size_t> delays;
  for (std::size_t i = 0; i < members_.size(); ++i) {
    if (IsDelay(members_[i])) delays.push_back(i);
  }
  const bool several = delays.size() > 1 && std::ranges::any_of(delays, [&](std::size_t i) {
                         return !DelaysBeside(members_[i], kNoMember).empty();
                       });
  if (several) SolveDelays(delays);
  const auto settle = [&](Candidate* candidate) {
    SetDelaysBeside(kNoMember, candidate);
    Place(candidate);
  };
  for (const std::size_t i : delays) {
    if (!several) {
      settle(&members_[i]);
      continue;
    }
    members_[i].columns.clear();
    members_[i].raw.reset();
    Place(&members_[i]);
  }
  for (std::size_t i = 0; i < members_.size(); ++i) {
    if (members_[i].of_one_run()) settle(&members_[i]);
  }
  for (Candidate& candidate : pool_) settle(&candidate);
  std::vector<Delay> all;
  for (const std::size_t i : delays) all.push_back(DelayOfMember(members_[i]));
  longest_delay_s_ = Longest_s(*problem_, all);
}

}  // namespace gyrobench::calibration
