// Delays add in time: each has the shape of all of them together.
#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

#include "calibration/gls/scaled_ldlt.h"
#include "calibration/trace/selection.h"

namespace gyrobench::calibration {
namespace {

Delay DelayOfMember(const Candidate& member) {
  return {member.effect->delay_s, member.context.nonlinear.front()};
}

// Delays apart by so little have the same shape: at 20 deg/s they turn the table by 2 mdeg, and the
// shapes of two ramps differ by a small part of that.
bool AreAlike(std::span<const StateHistory> histories, const std::vector<Delay>& a,
              const std::vector<Delay>& b) {
  constexpr double kSame_s = 1e-4;
  if (a.empty() || b.empty()) return a.empty() == b.empty();
  return DelaysApart_s(histories, a, b) < kSame_s;
}

}  // namespace

// Of the members but one, and but the candidate's own family; none where all together are short.
std::vector<Delay> Selection::DelaysBeside(const Candidate& candidate, std::size_t without) const {
  std::vector<Delay> delays;
  for (std::size_t i = 0; i < members_.size(); ++i) {
    if (i != without && members_[i].is_delay() && members_[i].family != candidate.family)
      delays.push_back(DelayOfMember(members_[i]));
  }
  std::vector<Delay> all = delays;
  if (candidate.is_delay()) all.push_back(DelayOfMember(candidate));
  return LongestDelay_s(problem_->histories(), all) < kLongDelay_s ? std::vector<Delay>() : delays;
}

// Its columns come anew where the delays beside it are others than those that it was made for.
void Selection::SetDelaysBeside(std::size_t without, Candidate* candidate) const {
  if (candidate->effect == nullptr || !candidate->effect->of_delay()) return;
  std::vector<Delay> delays = DelaysBeside(*candidate, without);
  if (AreAlike(problem_->histories(), delays, candidate->context.other_delays)) return;
  candidate->context.other_delays = std::move(delays);
  candidate->raw.reset();
  candidate->columns.clear();
}

// Each of the delays with all others beside it.
void Selection::TellEachOther(std::vector<Candidate>* delays) {
  for (Candidate& delay : *delays) {
    delay.context.other_delays.clear();
    for (const Candidate& other : *delays) {
      if (&other != &delay) delay.context.other_delays.push_back(DelayOfMember(other));
    }
    delay.raw.reset();
    delay.columns.clear();
  }
}

// The coefficients of the members that are delays, found together until their shapes are those of
// their sum; as they were where they cannot be told from each other.
void Selection::SolveDelays(const std::vector<std::size_t>& members) {
  constexpr int kRounds = 10;
  constexpr double kSame = 1e-6;  // of a range
  WhiteStore::Columns others = base_;
  for (std::size_t i = 0; i < members_.size(); ++i) {
    if (!members_[i].is_delay())
      others.insert(others.end(), members_[i].columns.begin(), members_[i].columns.end());
  }
  const Projection others_off(store_.Take(others));
  Eigen::MatrixXd of_output;
  const Eigen::VectorXd residual = others_off.Off(store_.output(), &of_output);
  std::vector<Candidate> delays;
  for (const std::size_t i : members) delays.push_back(members_[i]);
  Eigen::MatrixXd x(residual.size(), static_cast<Eigen::Index>(delays.size()));
  Eigen::VectorXd first(x.cols());
  double most = 1.0;
  for (int round = 0; round < kRounds && most > kSame; ++round) {
    TellEachOther(&delays);
    for (Eigen::Index j = 0; j < x.cols(); ++j) {
      Eigen::MatrixXd of_column;
      x.col(j) = others_off.Off(White(delays[static_cast<std::size_t>(j)]), &of_column).col(0);
      first(j) = of_column(0, 0);
    }
    const Eigen::VectorXd c = ScaledLdlt(x.transpose() * x).Solve(x.transpose() * residual);
    const double scale = ScaleFactorOr(of_output(0, 0) - first.dot(c));
    most = 0.0;
    for (Eigen::Index j = 0; j < x.cols(); ++j) {
      Candidate& delay = delays[static_cast<std::size_t>(j)];
      const NonlinearParameter& range = delay.effect->nonlinear.front();
      double& value = delay.context.nonlinear.front();
      const double now = c(j) / scale;
      if (!(now >= range.low && now <= range.high)) return;
      most = std::max(most, std::fabs(now - value) / (range.high - range.low));
      value = now;
    }
  }
  TellEachOther(&delays);
  for (std::size_t k = 0; k < members.size(); ++k) {
    Place(&delays[k]);
    members_[members[k]] = std::move(delays[k]);
  }
}

// After each change of the model.
void Selection::AddDelaysInTime() {
  std::vector<std::size_t> members;
  bool others_changed = false;
  for (std::size_t i = 0; i < members_.size(); ++i) {
    if (!members_[i].is_delay()) continue;
    members.push_back(i);
    const std::vector<Delay> beside = DelaysBeside(members_[i], kNoMember);
    others_changed = others_changed ||
                     !AreAlike(problem_->histories(), beside, members_[i].context.other_delays);
  }
  if (others_changed) SolveDelays(members);
  std::vector<Delay> delays;
  for (const std::size_t i : members) delays.push_back(DelayOfMember(members_[i]));
  longest_delay_s_ = LongestDelayLeft_s(problem_->histories(), delays);
  const auto settle = [&](Candidate* candidate) {
    SetDelaysBeside(kNoMember, candidate);
    Place(candidate);
  };
  for (Candidate& member : members_) {
    if (member.of_one_run()) settle(&member);
  }
  for (Candidate& candidate : pool_) settle(&candidate);
}

}  // namespace gyrobench::calibration
