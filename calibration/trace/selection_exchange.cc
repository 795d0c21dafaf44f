// What may take a member's place, or explains as much in it.
#include <algorithm>
#include <cmath>
#include <map>
#include <optional>
#include <set>
#include <string>
#include <utility>

#include "calibration/gls/scaled_ldlt.h"
#include "calibration/gls/statistics.h"
#include "calibration/trace/refine.h"
#include "calibration/trace/selection.h"

namespace gyrobench::calibration {
namespace {

// Ten of -2 log L, with the same for what a column costs: rivals.
constexpr double kRivalGain = 10.0;
// Motion, filter and reference are known to a hundredth: of two shapes that are as near to each
// other, no gain says which it is.
constexpr double kAlike = Effect::kShapeError * Effect::kShapeError;  // of what one explains
// Of -2 log L: what an error of a shape may leave matters from here on.
constexpr double kWorthTakingIn = 1.0;
// What a point of a grid explains, of what a refined one may.
constexpr double kNearOnGrid = 0.5;

bool IsSlow(const Candidate& candidate) {
  return candidate.effect != nullptr && candidate.effect->slow;
}

bool IsLimited(const Candidate& candidate) {
  return candidate.effect != nullptr && candidate.effect->limited;
}

}  // namespace

std::vector<Selection::Ramp> Selection::RampsFor(const Candidate& member,
                                                 const WhiteStore::Columns& others) const {
  if (!IsSlow(member)) return {};
  std::vector<Ramp> ramps = BestRamps(others);
  if (!member.bias_step()) return ramps;
  // A step in time may be a jump at the value that the quantity had then.
  constexpr double kWidth = 1e-4;  // of the quantity's range
  const Projection model_off(store_.Take(others));
  for (const CurveCells& cells : candidates_->cells) {
    const double value = ValueAt(*problem_, cells.factor, covariates(), member);
    const double half = 0.5 * kWidth * (cells.edges.back() - cells.edges.front());
    Ramp ramp;
    ramp.candidate = EmpiricalCandidate(*problem_, cells.factor, value - half, value + half);
    const Eigen::VectorXd column = White(ramp.candidate);
    const Eigen::VectorXd left = model_off.Off(column);
    if (!(left.squaredNorm() > kAbsorbed * column.squaredNorm())) continue;
    ramp.gain = std::pow(left.dot(store_.output()), 2) / left.squaredNorm();
    ramp.candidate.log_level = member.log_level;
    ramps.push_back(std::move(ramp));
  }
  return ramps;
}

// Of each slow family of the pool whose non-linear parameters are searched for the best, refined: a
// curve lies where it explains most, a point of a grid does not.
std::vector<Candidate> Selection::RefinedFor(std::size_t member, const WhiteStore::Columns& others,
                                             double cost_of_curve) {
  struct Point {
    const Candidate* candidate = nullptr;
    double cost = 0.0;
  };
  std::map<std::string, Point> best;
  for (const Candidate& candidate : pool_) {
    if (!candidate.searched() || !IsSlow(candidate) || Barred(candidate.family) ||
        InAnotherShape(candidate, member))
      continue;
    const double cost = CostWith(candidate, others);
    Point& point = best[candidate.family];
    if (point.candidate == nullptr || cost < point.cost) point = {&candidate, cost};
  }
  const double bare = Cost(others);
  std::vector<Candidate> out;
  for (const auto& [family, point] : best) {
    if (bare - point.cost < kNearOnGrid * (bare - cost_of_curve)) continue;
    out.push_back(*point.candidate);
    Refine(&out.back(), others);
    Place(&out.back());
  }
  return out;
}

// Of the pool what changes its shape with its size, and explains half of what the member does. A
// point of the grid has the shape of a small one: where the effect is large, its own shape tells it
// from others.
std::vector<Candidate> Selection::GrownFor(std::size_t member, const WhiteStore::Columns& others) {
  constexpr double kLarge = 1000.0;  // of -2 log L
  const double bare = Cost(others), gain = bare - Cost(ModelColumns());
  std::vector<Candidate> out;
  if (gain < kLarge) return out;
  for (const Candidate& candidate : pool_) {
    if (candidate.search() != Search::kCoefficient || Barred(candidate.family) ||
        InAnotherShape(candidate, member))
      continue;
    if (bare - CostWith(candidate, others) < kNearOnGrid * gain) continue;
    out.push_back(candidate);
    SetDelaysBeside(member, &out.back());
    Refine(&out.back(), others);
    Place(&out.back());
  }
  return out;
}

// What the pool has of the member's effect in another shape, at the member's place: a point of its
// grid explains less than what was refined.
std::optional<Candidate> Selection::InTheOtherShape(const Candidate& member,
                                                    const WhiteStore::Columns& others) {
  const auto other = std::ranges::find_if(pool_, [&](const Candidate& candidate) {
    return candidate.effect != nullptr && candidate.effect == member.effect &&
           candidate.context.of_stand != member.context.of_stand;
  });
  if (other == pool_.end()) return std::nullopt;
  Candidate candidate = *other;
  SetNonlinear(member.context.nonlinear, &candidate);
  candidate.columns.clear();
  Refine(&candidate, others);
  Place(&candidate);
  return candidate;
}

void Selection::SeeWhatShapesLeave() {
  // Of what a delay or a lag explains, once all that is of the second and third order is taken in.
  constexpr double kBeyondThirdOrder = 1e-6;
  left_by_shape_.clear();
  of_shape_.assign(members_.size(), {});
  const double all = Cost(ModelColumns());
  for (std::size_t i = 0; i < members_.size(); ++i) {
    const double gain = Cost(ModelWithout(i)) - all;
    const Effect* const effect = members_[i].effect;
    double left = gain * (effect != nullptr ? std::pow(effect->shape_error, 2) : kAlike);
    if (left > kWorthTakingIn && TakeInShapeOf(members_[i], &of_shape_[i]))
      left = gain * kBeyondThirdOrder;
    left_by_shape_.push_back(left);
  }
}

// Whatever the filter is, a gyro that is late by tau shows Phi(t - tau), a share of the second and
// of the third derivative of Phi, and what is of higher order: so much do a delay, a lag and any
// other filter differ.
bool Selection::TakeInShapeOf(const Candidate& member, WhiteStore::Columns* columns) {
  constexpr double kStep_s = 0.02;
  if (member.effect == nullptr || !member.effect->filter_shape) return false;
  if (of_filter_.empty()) {
    const Effect& delay = *std::ranges::find_if(EffectCatalogue(), [](const Effect& effect) {
      return effect.filter_shape && effect.delay_s != nullptr;
    });
    const auto late_by = [&](double tau_s) {
      return White(PlacedCandidate(*problem_, delay, 0, {tau_s}, {}));
    };
    const Eigen::MatrixXd after = late_by(kStep_s), before = late_by(-kStep_s);
    Eigen::MatrixXd shapes(after.rows(), 2);
    shapes << after - before, after - 2.0 * late_by(0.0) + before;
    of_filter_ = store_.Add(shapes);
  }
  *columns = of_filter_;
  return true;
}

WhiteStore::Columns Selection::BesideShapes(WhiteStore::Columns model, std::size_t beside) const {
  for (std::size_t i = 0; i < of_shape_.size(); ++i) {
    if (i == beside) continue;
    for (const Eigen::Index column : of_shape_[i]) {
      if (std::ranges::find(model, column) == model.end()) model.push_back(column);
    }
  }
  return model;
}

double Selection::CostWith(const Candidate& candidate, const WhiteStore::Columns& others) const {
  WhiteStore::Columns with = others;
  with.insert(with.end(), candidate.columns.begin(), candidate.columns.end());
  return Cost(with) + candidate.complexity_penalty();
}

// One member for another that explains more.
bool Selection::ExchangeMember(std::size_t i) {
  const WhiteStore::Columns others = ModelWithout(i);
  double least = Cost(ModelColumns()) - 1.0 + members_[i].complexity_penalty();
  std::optional<Candidate> better;
  auto consider = [&](const Candidate& candidate) {
    const double cost = CostWith(candidate, others);
    if (cost >= least || !Plausible(candidate, others)) return;
    least = cost;
    better = candidate;
  };
  for (const Candidate& candidate : pool_) {
    if (candidate.family == members_[i].family || Barred(candidate.family) ||
        InAnotherShape(candidate, i))
      continue;
    // Beside a long delay its shape is that beside this member: GrownFor has it without.
    if (members_[i].is_delay() && !candidate.context.other_delays.empty()) continue;
    consider(candidate);
  }
  for (const Ramp& ramp : RampsFor(members_[i], others)) {
    const double cost =
        Cost(others) - ramp.gain + kCostOfColumn + ramp.candidate.complexity_penalty();
    if (cost >= least || Barred(ramp.candidate.family)) continue;
    least = cost;
    better = ramp.candidate;
  }
  if (better ? better->empirical() : members_[i].empirical()) {
    const Eigen::Index mark = store_.used();
    const double before = least;
    for (const Candidate& candidate : RefinedFor(i, others, least)) consider(candidate);
    if (least == before) store_.DropFrom(mark);
  }
  if (const Eigen::Index mark = store_.used(); !better) {
    for (const Candidate& candidate : GrownFor(i, others)) consider(candidate);
    if (!better) store_.DropFrom(mark);
  }
  const Eigen::Index mark = store_.used();
  if (const std::optional<Candidate> shape = InTheOtherShape(members_[i], others)) {
    const double before = least;
    consider(*shape);
    if (least == before) store_.DropFrom(mark);
  }
  if (!better) return false;
  SetDelaysBeside(i, &*better);
  Refine(&*better, others);
  Place(&*better);
  members_[i] = std::move(*better);
  AddDelaysInTime();
  return true;
}

bool Selection::Exchange() {
  bool changed = false;
  for (std::size_t i = 0; i < members_.size(); ++i) changed = ExchangeMember(i) || changed;
  return changed;
}

// With coefficients that together are no larger than its largest size.
LimitedGain Selection::GainWithinItsLimit(const Candidate& candidate,
                                          const WhiteStore::Columns& others) const {
  const WhiteStore::Remainder left = store_.RemainderOf(candidate.columns, others);
  double square = 0.0;
  for (const Eigen::Index column : candidate.columns)
    square = std::max(square, store_.column(column).squaredNorm());
  return GainOfLength(left.products, left.with_output, kAbsorbed * square,
                      candidate.effect->typical_size * std::fabs(own_scale_));
}

// A description is no rival of a name on which it has no clear lead: what it must be ahead by to be
// chosen counts here too. In the member's place a rival must pass its own level, or nearly so: the
// credit for fewer coefficients alone makes no rival of what explains hardly anything.
std::vector<std::string> Selection::Rivals(std::size_t member) const {
  const WhiteStore::Columns others = ModelWithout(member);
  const double mine = Cost(ModelColumns());
  const double most = std::max(kRivalGain, kAlike * (Cost(others) - mine));
  auto rivals = [&](const Candidate& candidate, double cost) {
    const bool describes = candidate.effect == nullptr && members_[member].effect != nullptr;
    return cost + (describes ? candidate.complexity_penalty() : 0.0) - mine < most;
  };
  auto found = [](const Candidate& candidate, double log_p) {
    return log_p - candidate.log_level < 0.5 * kRivalGain;
  };
  std::set<std::string> names;
  for (const Candidate& candidate : pool_) {
    if (candidate.id == members_[member].id || InModel(candidate.family)) continue;
    // With what is named for one run, that of another run can take the place of the first run's.
    if (candidate.of_one_run() && Names(candidate.id)) continue;
    if (IsLimited(candidate)) {
      const LimitedGain limited = GainWithinItsLimit(candidate, others);
      if (rivals(candidate, Cost(others) - limited.gain + kCostOfColumn * limited.rank) &&
          found(candidate, candidate.LogChance(limited.gain, limited.rank)))
        names.insert(candidate.id);
      continue;
    }
    WhiteStore::Columns with = others;
    with.insert(with.end(), candidate.columns.begin(), candidate.columns.end());
    if (rivals(candidate, Cost(with)) && found(candidate, LogP(candidate, others, member)) &&
        Plausible(candidate, others))
      names.insert(candidate.id);
  }
  for (const Ramp& ramp : RampsFor(members_[member], others)) {
    if (rivals(ramp.candidate, Cost(others) - ramp.gain + kCostOfColumn) &&
        found(ramp.candidate, LogChiSquareTail(ramp.gain, 1.0)))
      names.insert(ramp.candidate.id);
  }
  return {names.begin(), names.end()};
}

}  // namespace gyrobench::calibration
