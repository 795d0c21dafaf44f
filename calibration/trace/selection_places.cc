// Where a member acts: its non-linear parameters, the time of a step, the side at which play
// begins.
#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <span>
#include <utility>
#include <vector>

#include "calibration/gls/scaled_ldlt.h"
#include "calibration/trace/refine.h"
#include "calibration/trace/selection.h"

namespace gyrobench::calibration {
namespace {

// Of -2 log L: less is no reason to let a power-on begin at a side of the play.
constexpr double kStartGain = 10.0;
constexpr double kFinestSide = 0.01;  // of the play
// The same of a number of periods a turn that is not the whole one where the scan has found it:
// what turns has whole numbers of teeth, poles and steps. Chance gains more in one of 200.
constexpr double kFromWhole = 8.0;

// Of the row in [first, end) that the time is in, and of those beside it.
double LongestRowAt(const ChannelProblem& problem, double t_s, Eigen::Index first,
                    Eigen::Index end) {
  Eigen::Index row = first;
  while (row + 1 < end && problem.begin_s(row + 1) <= t_s) ++row;
  double longest_s = 0.0;
  for (Eigen::Index i = std::max(first, row - 1); i < std::min(end, row + 2); ++i)
    longest_s = std::max(longest_s, problem.intervals()[static_cast<std::size_t>(i)].duration_s);
  return longest_s;
}

// Column of a step in the rows that it may act in.
Eigen::VectorXd RawInPowerOn(const ChannelProblem& problem, const Candidate& step) {
  return step.power_on ? problem.ColumnsIn(*step.power_on, *step.effect, step.context)
                       : problem.Columns(*step.effect, step.context);
}

// Of `map`, by Steffensen's method: iteration alone takes dozens of rounds where a delay is a good
// part of a ramp.
template <typename Map>
double FixedPoint(const Map& map, double at, double low, double high) {
  constexpr int kRounds = 5;
  const double same = 1e-6 * (high - low);
  for (int i = 0; i < kRounds; ++i) {
    const double once = map(at);
    const double twice = map(once);
    const double bend = twice - 2.0 * once + at;
    if (std::fabs(twice - once) < same || bend == 0.0) return twice;
    at = std::clamp(at - (once - at) * (once - at) / bend, low, high);
  }
  return map(at);
}

}  // namespace

// Variable projection against everything else in the model.
void Selection::Refine(Candidate* candidate, const WhiteStore::Columns& others) {
  const std::optional<RefineRange> range = RangeOf(*problem_, *candidate);
  if (!range) return;
  const Projection others_off(store_.Take(others));
  Eigen::MatrixXd of_output;
  const Eigen::VectorXd residual = others_off.Off(store_.output(), &of_output);
  Candidate trial = *candidate;
  auto columns = [&](const std::vector<double>& theta) {
    SetNonlinear(theta, &trial);
    return others_off.Off(White(trial));
  };
  // The scale factor beside it, too: without the candidate it may be another.
  auto coefficient = [&](double theta) {
    SetNonlinear({theta}, &trial);
    Eigen::MatrixXd of_column;
    const Eigen::VectorXd x = others_off.Off(White(trial), &of_column).col(0);
    const double square = x.squaredNorm();
    if (!(square > 0.0)) return theta;
    const double value = x.dot(residual) / square;
    const double scale = ScaleFactorOr(of_output(0, 0) - value * of_column(0, 0));
    return std::clamp(value / scale, range->low[0], range->high[0]);
  };
  const auto explained = [&](const std::vector<double>& at) {
    const Eigen::MatrixXd x = columns(at);
    return ScaledLdlt(x.transpose() * x).Square(x.transpose() * residual);
  };
  auto refined = [&](const std::vector<double>& from) {
    if (!range->is_coefficient)
      return RefineNonlinear(columns, residual, from, range->low, range->high);
    std::vector<double> theta = from;
    theta[0] = FixedPoint(coefficient, from[0], range->low[0], range->high[0]);
    // A play that explains less than a small one is none. A delay has the shape of its own size also
    // then: that of a small one is a lag's of first order.
    return candidate->is_play() && explained(theta) < explained(from) ? from : theta;
  };
  std::vector<double> theta = refined(range->start);
  if (candidate->search() == Search::kPeriods &&
      explained(theta) - explained(range->start) < kFromWhole)
    theta = range->start;
  bool changed = theta != range->start;
  if (changed) SetNonlinear(theta, candidate);
  if (candidate->effect != nullptr && candidate->effect->unknown_start) {
    trial.context.start_sides = StartSides(*candidate, others_off, residual);
    if (trial.context.start_sides != candidate->context.start_sides) {
      candidate->context.start_sides = trial.context.start_sides;
      SetNonlinear(refined(theta), candidate);
      changed = true;
    }
  }
  if (changed) candidate->columns.clear();
}

// Where in the play a power-on begins nobody knows; what it does first shows it.
std::vector<double> Selection::StartSides(Candidate candidate, const Projection& others_off,
                                          const Eigen::VectorXd& residual) const {
  std::vector<double>& sides = candidate.context.start_sides;
  const std::span<const StateHistory> histories = problem_->histories();
  sides.assign(static_cast<std::size_t>(std::ranges::count_if(
                   histories, [](const StateHistory& history) { return history.new_power_on; })),
               0.0);
  candidate.raw.reset();
  const auto gain = [&] {
    const Eigen::VectorXd x = others_off.Off(White(candidate)).col(0);
    const double with = x.dot(residual);
    return with * with / x.squaredNorm();
  };
  double best = gain();
  for (double& side : sides) {
    double chosen = 0.0, with = best + kStartGain;
    auto try_at = [&](double start) {
      side = std::clamp(start, -0.5, 0.5);
      if (const double here = gain(); here > with) {
        with = here;
        chosen = side;
      }
    };
    for (const double start : {-0.5, 0.5, -0.25, 0.25}) try_at(start);
    for (double step = 0.125; chosen != 0.0 && step > kFinestSide; step *= 0.5) {
      for (const double start : {chosen - step, chosen + step}) try_at(start);
    }
    side = chosen;
    if (chosen != 0.0) best = with;
  }
  if (std::ranges::all_of(sides, [](double side) { return side == 0.0; })) sides.clear();
  return sides;
}

// Within the rows around: a part of what one stands for may be before the step. Roughly first, then
// closely.
void Selection::PlaceStep(const WhiteStore::Columns& others, Candidate* candidate) const {
  constexpr int kPlaces = 8;                                           // on either side
  constexpr std::array kSteps = {1.0 / 4.0, 1.0 / 32.0, 1.0 / 256.0};  // of a row
  // A step is 0 in other power-ons: its own rows do.
  const std::optional<std::size_t> power_on = candidate->power_on;
  const Eigen::Index first = power_on ? problem_->begin_of(*power_on) : 0;
  const Eigen::Index rows = (power_on ? problem_->end_of(*power_on) : problem_->rows()) - first;
  const ScaledLdlt products(store_.Products(others));
  const Eigen::MatrixXd own = store_.Take(others, first, rows);
  const Eigen::VectorXd residual =
      store_.output().segment(first, rows) - own * store_.Solve(others);
  const bool by_readings = HasReadings(*candidate);
  const Eigen::VectorXd readings_left =
      by_readings ? ResidualOfReadings(others) : Eigen::VectorXd();
  double best_s = candidate->context.nonlinear[0];
  const double row_s = LongestRowAt(*problem_, best_s, first, first + rows);
  Eigen::MatrixXd columns(rows, 2 * kPlaces + 1);
  for (const double step : kSteps) {
    const double middle_s = best_s;
    auto place_s = [&](int place) { return middle_s + place * step * row_s; };
    for (int place = -kPlaces; place <= kPlaces; ++place) {
      SetNonlinear({place_s(place)}, candidate);
      columns.col(place + kPlaces) = RawInPowerOn(*problem_, *candidate);
    }
    whitener_.Apply(columns, first);
    const Eigen::MatrixXd with = own.transpose() * columns;
    double most = 0.0;
    for (int place = -kPlaces; place <= kPlaces; ++place) {
      const auto column = columns.col(place + kPlaces);
      double left = column.squaredNorm() - products.Square(with.col(place + kPlaces));
      if (!(left > kAbsorbed * column.squaredNorm())) continue;
      double score = column.dot(residual);
      if (by_readings) {
        SetNonlinear({place_s(place)}, candidate);
        const Eigen::VectorXd more = ColumnsOfReadings(*candidate).col(0);
        left += more.squaredNorm();
        score += more.dot(readings_left);
      }
      const double gain = score * score / left;
      if (!(gain > most)) continue;
      most = gain;
      best_s = place_s(place);
    }
  }
  SetNonlinear({best_s}, candidate);
}

// Each member that is searched, and play, among the others: what has been added since may have
// moved it. By how much that lowers the cost. Not ripples: a scan sees them sharply, beside
// whatever is slower.
double Selection::PlaceAgain() {
  const double before = Cost(ModelColumns());
  for (std::size_t i = 0; i < members_.size(); ++i) {
    const bool is_step = members_[i].search() == Search::kTime;
    const bool is_ripple = members_[i].search() == Search::kPeriods;
    if (is_ripple || !(is_step || members_[i].searched() || members_[i].is_play())) continue;
    if (members_[i].shape_held) continue;
    Candidate placed = members_[i];
    const WhiteStore::Columns others = ModelWithout(i);
    if (is_step) {
      PlaceStep(others, &placed);
    } else {
      Refine(&placed, others);
    }
    if (placed.context.nonlinear == members_[i].context.nonlinear &&
        placed.context.start_sides == members_[i].context.start_sides)
      continue;
    const Eigen::Index mark = store_.used();
    Store(&placed);
    // Plausible would take a step for a spike beside itself.
    if (CostWith(placed, others) < CostWith(members_[i], others) &&
        (is_step || Plausible(placed, others))) {
      members_[i] = std::move(placed);
    } else {
      store_.DropFrom(mark);
    }
  }
  return before - Cost(ModelColumns());
}

void Selection::PlaceWhatIsLeft() {
  if (!one_is_gone_) return;
  one_is_gone_ = false;
  PlaceUntilItGainsNothing();
}

// By the reference, what the channel turned from one step to another of its power-on, and by a
// reading before and after [deg].
double Selection::TurnedByReference_deg(const Candidate& from, const Candidate& to) const {
  const double from_s = from.context.nonlinear[0], to_s = to.context.nonlinear[0];
  const Eigen::Index begin = from.power_on ? problem_->begin_of(*from.power_on) : 0;
  const Eigen::Index end = from.power_on ? problem_->end_of(*from.power_on) : problem_->rows();
  double turned_deg = 0.0;
  for (Eigen::Index i = begin; i < end; ++i) {
    if (problem_->end_s(i) < from_s - kBetweenNodes_s) continue;
    if (problem_->begin_s(i) > to_s + kBetweenNodes_s) continue;
    const ProblemRow& row = problem_->row_refs()[static_cast<std::size_t>(i)];
    turned_deg += problem_->history(i).rotation_deg[row.interval][problem_->channel()];
  }
  return turned_deg;
}

// Two steps were each placed by itself, and no spike then. A channel whose own turns have no column
// stands still: what the reference says that it turned by is a reading that jumps, all at once or
// in the mean over a rest.
bool Selection::MakesSpikeWith(const Candidate& member, const Candidate& other) const {
  constexpr double kNearly = 0.3, kLongest_s = 5.0;
  if (!member.bias_step() || !other.bias_step() || member.power_on != other.power_on) return false;
  const double lasts_s = other.context.nonlinear[0] - member.context.nonlinear[0];
  if (std::fabs(lasts_s) < kBetweenNodes_s) return true;
  if (turns_itself_ || !(lasts_s > 0.0) || lasts_s > kLongest_s) return false;
  const WhiteStore::Columns model = ModelColumns();
  const auto place = std::ranges::find(model, member.columns.front()) - model.begin();
  const double turned_deg = store_.Solve(model)(place) * lasts_s;
  return std::fabs(turned_deg + TurnedByReference_deg(member, other)) <
         kNearly * std::fabs(turned_deg);
}

std::optional<std::pair<std::size_t, std::size_t>> Selection::FindSpike() const {
  for (std::size_t i = 0; i < members_.size(); ++i) {
    for (std::size_t j = 0; j < members_.size(); ++j) {
      if (i != j && MakesSpikeWith(members_[i], members_[j])) return std::pair(i, j);
    }
  }
  return std::nullopt;
}

std::vector<double> Selection::DropSpikes() {
  std::vector<double> times_s;
  while (const auto spike = FindSpike()) {
    const auto& [up, down] = *spike;
    times_s.push_back(members_[up].context.nonlinear[0]);
    Remove(std::max(up, down));
    Remove(std::min(up, down));
  }
  return times_s;
}

void Selection::PlaceUntilItGainsNothing() {
  constexpr int kMostRounds = 5;
  constexpr double kHardly = 0.05;  // of -2 log L
  for (int i = 0; i < kMostRounds && PlaceAgain() > kHardly;) ++i;
}

}  // namespace gyrobench::calibration
