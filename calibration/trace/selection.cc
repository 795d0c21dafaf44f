#include "calibration/trace/selection.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <set>
#include <string>
#include <utility>

#include "calibration/gls/scaled_ldlt.h"
#include "calibration/gls/statistics.h"
#include "calibration/signal/columns.h"
#include "calibration/trace/refine.h"

namespace gyrobench::calibration {
namespace {

constexpr std::size_t kMostEffects = 12;
constexpr double kImplausibleIsWorse = 1e6;  // than any lack of evidence, as logarithms of chances
constexpr double kUnlimited = std::numeric_limits<double>::infinity();
// Standard errors beyond which a coefficient is above a limit.
constexpr double kSure = 4.0;

// Columns of the store, with some for what scans and refinement add.
Eigen::Index RoomFor(const Baseline& baseline, const CandidateSet& candidates) {
  Eigen::Index room = baseline.columns.cols() + 40;
  for (const CurveCells& cells : candidates.cells) room += cells.raw.cols();
  for (const Candidate& candidate : candidates.grid) room += candidate.raw->cols();
  return room;
}

// The best number of periods a turn may be as far from a whole number as any may be: then it is
// farther, and fits nothing that turns. Of many periods any number is near enough to a whole one.
bool AtTheEndOfItsRange(const Candidate& ripple) {
  constexpr double kNearlyAll = 0.999;
  const double periods = ripple.context.nonlinear[0], whole = std::round(periods);
  const double may_be_off = OffWholePeriods(whole);
  return may_be_off < 0.5 && std::fabs(periods - whole) > kNearlyAll * may_be_off;
}

// What the gyro turns by within a delay beyond the samples about a node is known by its scale
// factor, which may err by 6e-4 where the reference is late, and the ways between nodes: of 3 deg
// within 0.15 s to 0.001 deg. A smaller wave of the angle would make up for that.
double LeastBesideDelay_deg(const ChannelProblem& problem, double longest_delay_s) {
  constexpr double kKnown = 1e-3;
  return longest_delay_s > kNear_s.back()
             ? kKnown * longest_delay_s * problem.mean_rate_in_motion_deg_s()
             : 0.0;
}

// A term of which these data would not see an implausible size is left at 0: its coefficient would
// be noise, and a part that is corrected by it would be wrong wherever the term does act. `white`:
// all columns of the store.
void DropBlindTerms(const Projection& baseline, Candidate* candidate,
                    Eigen::Ref<Eigen::MatrixXd> white) {
  const Effect* effect = candidate->effect;
  if (effect == nullptr || effect->terms.size() < 2 || !effect->nonlinear.empty() ||
      !(effect->typical_size > 0))
    return;
  const double least_square = std::pow(Effect::kImplausible * effect->typical_size, -2);
  std::optional<Eigen::MatrixXd> raw;
  for (std::size_t k = 0; k < candidate->columns.size(); ++k) {
    if (baseline.Off(white.col(candidate->columns[k])).squaredNorm() > least_square) continue;
    if (!raw) raw = candidate->raw->Copy();
    raw->col(static_cast<Eigen::Index>(k)).setZero();
    white.col(candidate->columns[k]).setZero();
  }
  if (raw) candidate->raw = candidate->Limited(std::move(*raw));
}

}  // namespace

Selection::Selection(const ChannelProblem& problem, const Baseline& baseline,
                     const NoiseModel& noise, const CandidateSet& candidates,
                     const SelectionOptions& options)
    : problem_(&problem),
      candidates_(&candidates),
      options_(options),
      whitener_(problem.intervals(), noise),
      walk_deg_sqrt_s_(noise.angle_random_walk_deg_sqrt_s),
      store_(
          [&] {
            Eigen::MatrixXd output = problem.output_deg();
            whitener_.Apply(output);
            return Eigen::VectorXd(output);
          }(),
          RoomFor(baseline, candidates)),
      pool_(candidates.grid) {
  Eigen::Index count = baseline.columns.cols();
  for (const CurveCells& cells : candidates.cells) count += cells.raw.cols();
  for (const Candidate& candidate : pool_) count += candidate.raw->cols();
  Eigen::Ref<Eigen::MatrixXd> all = store_.Places(count);
  Eigen::Index used = 0;
  std::vector<RawColumns> raw;
  auto place = [&](const RawColumns& some) {
    raw.push_back(some);
    WhiteStore::Columns columns;
    for (Eigen::Index j = 0; j < some.cols(); ++j) columns.push_back(used++);
    return columns;
  };
  base_ = place(RawColumns(baseline.columns));
  for (const CurveCells& cells : candidates.cells) cells_.push_back(place(cells.raw));
  for (Candidate& candidate : pool_) candidate.columns = place(*candidate.raw);
  whitener_.Whiten(raw, all);
  of_sensor_ = baseline.of_sensor();
  const Projection baseline_off(all.leftCols(of_sensor_));
  for (Candidate& candidate : pool_) DropBlindTerms(baseline_off, &candidate, all);
  store_.Add(count);
  HoldMisreadPlaces(baseline.misread_places);
  store_.MultiplyFirst(static_cast<Eigen::Index>(base_.size()));
  for (const WhiteStore::Columns& cells : cells_) store_.MultiplyEachOther(cells);
  turned_ = static_cast<Eigen::Index>(baseline.turned.size());
  if (turned_ > 0 && baseline.turned.front() == problem.channel()) {
    const double scale = store_.Solve(base_)(0);
    turns_itself_ = std::fabs(scale) > kLeastScaleFactor;
    if (turns_itself_) own_scale_ = scale;
  }
  TakeInMoreRows(baseline);
  std::erase_if(pool_, [&](const Candidate& candidate) {
    if (Visible(candidate)) return false;
    unseen_.push_back(candidate);
    return true;
  });
  ShareLevels();
}

// Every id gets the same share, as do steps of the offset, of the angle, tones and ripples; of it
// every family of the id, as of the axes of the stand, as much as any other; and its grid points as
// many parts of that as they are tests that do not repeat each other: the eigenvalues of their
// correlation say how many (Li and Ji 2005).
void Selection::ShareLevels() {
  std::map<std::string, std::vector<Candidate*>> families;
  std::map<std::string, std::set<std::string>> families_of;  // of an id
  for (Candidate& candidate : pool_) {
    families[candidate.family].push_back(&candidate);
    families_of[candidate.id].insert(candidate.family);
  }
  log_level_of_id_ = std::log(options_.false_discovery * kShareOfEffects /
                              static_cast<double>(families_of.size() + kKindsOfScan));
  for (auto& [family, points] : families) {
    double tests = 1.0;
    if (points.size() > 1) {
      WhiteStore::Columns first;
      for (const Candidate* point : points) first.push_back(point->columns.front());
      const Eigen::MatrixXd products = store_.RemainderOf(first, base_).products;
      const Eigen::VectorXd scale = products.diagonal().cwiseMax(1e-300).cwiseSqrt().cwiseInverse();
      const Eigen::VectorXd values =
          Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd>(
              Eigen::MatrixXd(scale.asDiagonal() * products * scale.asDiagonal()),
              Eigen::EigenvaluesOnly)
              .eigenvalues();
      tests = 0.0;
      for (const double value : values)
        tests += value >= 1.0 ? 1.0 + value - std::floor(value) : std::max(value, 0.0);
      tests = std::clamp(tests, 1.0, static_cast<double>(points.size()));
    }
    for (Candidate* point : points) {
      const auto own = static_cast<double>(families_of[point->id].size());
      point->log_level = log_level_of_id_ - std::log(own * tests);
    }
  }
}

// Within its bound every part of this class would be: a value that is found would be an invention.
bool Selection::Visible(const Candidate& candidate) const {
  if (candidate.effect == nullptr || !(candidate.effect->typical_size > 0)) return true;
  for (const Eigen::Index column : candidate.columns) {
    const double square = store_.Left(column, base_) * store_.Square(column);
    if (square > std::pow(candidate.effect->typical_size, -2)) return true;
  }
  return false;
}

// Of the candidate's j-th coefficient in a model that it is in.
double Selection::StdError(const Candidate& candidate, std::size_t j,
                           WhiteStore::Columns model) const {
  const Eigen::Index column = candidate.columns[j];
  std::erase(model, column);
  return 1.0 / std::sqrt(store_.Left(column, model) * store_.Square(column));
}

double Selection::ScaleFactorOr(double first_of_model) const {
  return turns_itself_ && std::fabs(first_of_model) > kLeastScaleFactor ? first_of_model
                                                                        : own_scale_;
}

// A step and the one back before the next readings are one reading that is wrong.
bool Selection::IsSpike(const Candidate& candidate) const {
  if (candidate.search() != Search::kTime) return false;
  return std::ranges::any_of(members_, [&](const Candidate& member) {
    return member.effect == candidate.effect && member.power_on == candidate.power_on &&
           member.columns != candidate.columns &&
           std::fabs(member.context.nonlinear[0] - candidate.context.nonlinear[0]) <
               kBetweenNodes_s;
  });
}

// Whether its coefficients may be what the effect says, among the others of a model.
bool Selection::Plausible(const Candidate& candidate, const WhiteStore::Columns& others) const {
  if (MayBeRounding(candidate, others)) return false;
  if (candidate.effect == nullptr) return true;
  if (IsSpike(candidate)) return false;
  const Effect& effect = *candidate.effect;
  if (effect.search == Search::kPeriods && AtTheEndOfItsRange(candidate)) return false;
  const double largest =
      std::min(candidate.largest, effect.limited ? effect.typical_size : kUnlimited);
  if (!(effect.typical_size > 0) && !effect.positive && largest == kUnlimited) return true;
  WhiteStore::Columns model = others;
  model.insert(model.end(), candidate.columns.begin(), candidate.columns.end());
  const Eigen::VectorXd all = store_.Solve(model);
  const Eigen::VectorXd values = all.tail(static_cast<Eigen::Index>(candidate.columns.size()));
  const double scale = ScaleFactorOr(all(0));
  double least_deg = effect.made_by_rounding * problem_->rounding_deg();
  if (effect.domain == EffectDomain::kAngle && (effect.needs & kNeedsTableAxis) != 0)
    least_deg = std::max(least_deg, LeastBesideDelay_deg(*problem_, longest_delay_s_));
  if (values.norm() < least_deg * std::fabs(scale)) return false;
  if (effect.search == Search::kPeriods && MayBeOfReadings(candidate, values.norm(), scale, others))
    return false;
  if (effect.search == Search::kFrequency && MayBeToneOfReadings(candidate, all, others))
    return false;
  for (std::size_t j = 0; j < candidate.columns.size(); ++j) {
    double value = values(static_cast<Eigen::Index>(j));
    if (effect.domain == EffectDomain::kAngle) value /= scale;
    if (effect.positive && value < 0.0) return false;
    if (std::fabs(value) > effect.implausible_size()) return false;
    if (largest < kUnlimited && std::fabs(value) > largest + kSure * StdError(candidate, j, model))
      return false;
  }
  return true;
}

void Selection::Remove(std::size_t member) {
  one_is_gone_ = true;
  members_.erase(members_.begin() + static_cast<std::ptrdiff_t>(member));
  AddDelaysInTime();
}

void Selection::HoldShape(std::size_t member, const std::vector<double>& nonlinear) {
  Candidate& held = members_[member];
  SetNonlinear(nonlinear, &held);
  Store(&held);
  held.shape_held = true;
}

void Selection::SetGainByAnyNoise(std::size_t member, double gain) {
  members_[member].gain_over_noise = gain;
}

Eigen::MatrixXd Selection::White(const Candidate& candidate) const {
  Eigen::MatrixXd columns = ColumnsOf(*problem_, candidate, covariates());
  // Beyond its own power-on it is 0, and stays so.
  const Eigen::Index first = candidate.power_on ? problem_->begin_of(*candidate.power_on) : 0;
  const Eigen::Index end =
      candidate.power_on ? problem_->end_of(*candidate.power_on) : problem_->rows();
  whitener_.Apply(columns.middleRows(first, end - first), first);
  return columns;
}

WhiteStore::Columns Selection::ModelColumns() const { return ModelWithout(members_.size()); }

WhiteStore::Columns Selection::ModelWithout(std::size_t without) const {
  return FirstWithout(members_.size(), without);
}

WhiteStore::Columns Selection::FirstWithout(std::size_t count, std::size_t without) const {
  WhiteStore::Columns columns = base_;
  for (std::size_t i = 0; i < count; ++i) {
    if (i == without) continue;
    columns.insert(columns.end(), members_[i].columns.begin(), members_[i].columns.end());
  }
  return columns;
}

bool Selection::InModel(const std::string& family) const {
  return std::any_of(members_.begin(), members_.end(),
                     [&](const Candidate& member) { return member.family == family; });
}

bool Selection::Names(const std::string& id) const {
  return std::ranges::any_of(members_, [&](const Candidate& member) { return member.id == id; });
}

bool Selection::Barred(const std::string& family) const {
  return InModel(family) || implausible_.contains(family);
}

double Selection::Cost(const WhiteStore::Columns& columns) const {
  const WhiteStore::Fit fit = store_.FitTo(columns);
  return fit.residual_square + kCostOfColumn * fit.rank;
}

// Logarithm of the p-value of adding the candidate to the others, by what it gains beyond what
// errors of their shapes may leave.
double Selection::LogP(const Candidate& candidate, const WhiteStore::Columns& others,
                       std::size_t beside) const {
  WhiteStore::Columns with = BesideShapes(others, beside);
  const WhiteStore::Fit before = store_.FitTo(with);
  for (const Eigen::Index column : candidate.columns) {
    if (store_.Left(column, with) > kAbsorbed) with.push_back(column);
  }
  const WhiteStore::Fit after = store_.FitTo(with);
  const double gain = before.residual_square - after.residual_square;
  return candidate.LogChance(std::max(gain - LeftByShapes(beside), 0.0), after.rank - before.rank);
}

double Selection::LeftByShapes(std::size_t beside) const {
  double most = 0.0;
  for (std::size_t i = 0; i < left_by_shape_.size(); ++i)
    if (i != beside) most = std::max(most, left_by_shape_[i]);
  return most;
}

void Selection::Place(Candidate* candidate) {
  if (candidate->columns.empty()) Store(candidate);
}

void Selection::Insert(Candidate candidate) {
  Place(&candidate);
  members_.push_back(std::move(candidate));
}

// The best of the catalogue's grid, of the scans and of products, whatever is most surprising.
bool Selection::AddBest() {
  SeeWhatShapesLeave();
  const WhiteStore::Columns model = ModelColumns();
  Best best;
  TryPool(model, &best);
  TryScans(model, &best);
  TryProducts(&best);
  return Add(std::move(best), model);
}

// What nothing else explains.
bool Selection::AddCurve() {
  const WhiteStore::Columns model = ModelColumns();
  Best best;
  TryRamps(model, &best);
  return Add(std::move(best), model);
}

bool Selection::Add(Best best, const WhiteStore::Columns& model) {
  if (!best.candidate) return false;
  Candidate& candidate = *best.candidate;
  if (!candidate.scanned() && !best.refined) Refine(&candidate, model);
  Insert(std::move(candidate));
  AddDelaysInTime();
  return true;
}

// The newest member, where this one was what it may be before that came and explains more than it;
// else itself.
std::size_t Selection::MadeImplausibleBy(std::size_t member) const {
  const std::size_t newest = members_.size() - 1;
  if (member == newest || Cost(ModelWithout(newest)) > Cost(ModelWithout(member))) return member;
  return Plausible(members_[member], FirstWithout(newest, member)) ? newest : member;
}

bool Selection::DropWeak() {
  bool changed = false;
  for (;;) {
    SeeWhatShapesLeave();
    std::size_t weakest = members_.size();
    double lack = 0.0;
    for (std::size_t i = 0; i < members_.size(); ++i) {
      const WhiteStore::Columns others = ModelWithout(i);
      double over = LogP(members_[i], others, i) - members_[i].log_level;
      if (over <= 0.0 && !Plausible(members_[i], others)) over = kImplausibleIsWorse;
      if (over <= lack) continue;
      lack = over;
      weakest = i;
    }
    if (weakest == members_.size()) return changed;
    if (lack == kImplausibleIsWorse) {
      // The last one is the newest only as long as none is gone.
      if (!changed) weakest = MadeImplausibleBy(weakest);
      implausible_.insert(members_[weakest].family);
    }
    Remove(weakest);
    changed = true;
  }
}

// Until nothing is added that stays: what was dropped again would be added again.
void Selection::Grow(bool (Selection::*add)()) {
  for (std::size_t i = 0; i < 2 * kMostEffects && members_.size() < kMostEffects; ++i) {
    const std::multiset<std::string> before = Families();
    const std::size_t barred = implausible_.size();
    if (!(this->*add)()) return;
    if (members_.size() > 1) PlaceAgain();
    Exchange();
    DropWeak();
    if (Families() == before && implausible_.size() == barred) return;
  }
}

std::multiset<std::string> Selection::Families() const {
  std::multiset<std::string> out;
  for (const Candidate& member : members_) out.insert(member.family);
  return out;
}

void Selection::Run() {
  for (int round = 0; round < 3; ++round) {
    const std::multiset<std::string> before = Families();
    implausible_.clear();  // what was implausible among other members need not be so now
    Grow(&Selection::AddBest);
    Grow(&Selection::AddCurve);
    if (Families() == before) break;
  }
  if (members_.size() > 1 || one_is_gone_) PlaceUntilItGainsNothing();
  one_is_gone_ = false;
  SeeWhatShapesLeave();
}

double Selection::PValue(std::size_t member) const {
  const Candidate& candidate = members_[member];
  const double log_p = std::max(LogP(candidate, ModelWithout(member), member),
                                candidate.LogChance(candidate.gain_over_noise,
                                                    static_cast<double>(candidate.columns.size())));
  return std::min(1.0, std::exp(log_p - candidate.log_level) * options_.false_discovery);
}

Eigen::VectorXd Selection::Residual() const {
  const Eigen::MatrixXd model = store_.Take(ModelColumns());
  return store_.output() - model * store_.Solve(ModelColumns());
}

}  // namespace gyrobench::calibration
