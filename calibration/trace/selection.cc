#include "calibration/trace/selection.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <limits>
#include <set>

#include "calibration/trace/likelihood.h"
#include "calibration/trace/noise_search.h"
#include "calibration/trace/refine.h"
#include "calibration/trace/scans.h"

namespace gyrobench::calibration {
namespace {

// How the chance of a false discovery is shared out.
constexpr double kShareOfCatalogue = 0.6, kShareOfProducts = 0.1, kShareOfScan = 0.075;
// A scan's place so near to its level may pass it when it is refined.
constexpr double kNearLevel = 4.0;
constexpr std::size_t kMostEffects = 12;
// Many steps and tones are no cause but a residual that is not understood.
constexpr std::ptrdiff_t kMostScanned = 4;
// What a column must bring for an exchange of candidates of different size to be fair.
constexpr double kCostOfColumn = 8.0;
// Ten of -2 log L, with the same for what a column costs: rivals.
constexpr double kRivalGain = 10.0;
double Handicap(const Candidate& candidate) {
  return candidate.effect == nullptr ? 0.0 : candidate.effect->handicap;
}
// Less of a column's square left by the model: it is absorbed.
constexpr double kAbsorbed = 1e-6;

}  // namespace

Selection::Selection(const ChannelProblem& problem, const Baseline& baseline,
                     const IntervalNoise& noise, std::vector<std::string> covariates,
                     bool earth_rate_known, const SelectionOptions& options)
    : problem_(&problem),
      options_(options),
      covariates_(std::move(covariates)),
      whitener_(problem.intervals(), noise),
      store_(
          [&] {
            Eigen::MatrixXd output = problem.output_deg();
            whitener_.Apply(output);
            return Eigen::VectorXd(output);
          }(),
          180) {
  Eigen::MatrixXd columns = baseline.columns;
  whitener_.Apply(columns);
  base_ = store_.Add(columns);
  pool_ = CatalogueCandidates(problem, covariates_, earth_rate_known);
  products_ = ComposedCandidates(problem, covariates_);
  const double level = options.false_discovery * kShareOfCatalogue;
  std::erase_if(pool_, [&](Candidate& candidate) {
    const Eigen::MatrixXd white = White(candidate);
    if (!white.allFinite()) return true;
    const Eigen::Index mark = store_.used();
    candidate.columns = store_.Add(white);
    if (Visible(candidate)) return false;
    store_.DropFrom(mark);
    unseen_.push_back(candidate);
    return true;
  });
  for (Candidate& candidate : pool_) {
    candidate.log_level = std::log(level / static_cast<double>(pool_.size()));
  }
}

// Within its bound every part of this class would be: a value that is found would be an invention.
bool Selection::Visible(const Candidate& candidate) const {
  if (!(candidate.effect->typical_size > 0)) return true;
  for (const Eigen::Index column : candidate.columns) {
    const double square = store_.Left(column, base_) * store_.column(column).squaredNorm();
    if (square > std::pow(candidate.effect->typical_size, -2)) return true;
  }
  return false;
}

void Selection::Remove(std::size_t member) {
  members_.erase(members_.begin() + static_cast<std::ptrdiff_t>(member));
}

Eigen::MatrixXd Selection::White(const Candidate& candidate) const {
  Eigen::MatrixXd columns = ColumnsOf(*problem_, candidate, covariates_);
  whitener_.Apply(columns);
  return columns;
}

WhiteStore::Columns Selection::ModelColumns() const { return ModelWithout(members_.size()); }

WhiteStore::Columns Selection::ModelWithout(std::size_t without) const {
  WhiteStore::Columns columns = base_;
  for (std::size_t i = 0; i < members_.size(); ++i) {
    if (i == without) continue;
    columns.insert(columns.end(), members_[i].columns.begin(), members_[i].columns.end());
  }
  return columns;
}

bool Selection::InModel(const std::string& family) const {
  return std::any_of(members_.begin(), members_.end(),
                     [&](const Candidate& member) { return member.family == family; });
}

double Selection::Cost(const WhiteStore::Columns& columns) const {
  const WhiteStore::Fit fit = store_.FitTo(columns);
  return fit.residual_square + kCostOfColumn * fit.rank;
}

// Logarithm of the p-value of adding the candidate to the others.
double Selection::LogP(const Candidate& candidate, const WhiteStore::Columns& others,
                       double* gain) const {
  const WhiteStore::Fit before = store_.FitTo(others);
  WhiteStore::Columns with = others;
  for (const Eigen::Index column : candidate.columns) {
    if (store_.Left(column, with) > kAbsorbed) with.push_back(column);
  }
  const WhiteStore::Fit after = store_.FitTo(with);
  *gain = before.residual_square - after.residual_square;
  const int degrees = after.rank - before.rank;
  return degrees > 0 ? LogChiSquareTail(*gain, degrees) : 0.0;
}

void Selection::Insert(Candidate candidate) {
  if (candidate.columns.empty()) candidate.columns = store_.Add(White(candidate));
  members_.push_back(std::move(candidate));
}

// Variable projection against everything else in the model.
void Selection::Refine(Candidate* candidate, const WhiteStore::Columns& others) {
  if (candidate->effect == nullptr || candidate->effect->nonlinear.empty()) return;
  const Eigen::MatrixXd model = store_.Take(others);
  const Eigen::LDLT<Eigen::MatrixXd> factor(model.transpose() * model);
  auto off = [&](const Eigen::MatrixXd& columns) {
    return Eigen::MatrixXd(columns - model * factor.solve(model.transpose() * columns));
  };
  const Eigen::VectorXd residual = off(store_.output());
  Candidate trial = *candidate;
  auto columns = [&](const std::vector<double>& theta) {
    trial.context.nonlinear = theta;
    return off(White(trial));
  };
  const Effect& effect = *candidate->effect;
  if (effect.tied) {
    for (int i = 0; i < 6; ++i) {
      const Eigen::MatrixXd x = columns(candidate->context.nonlinear);
      const double coefficient = x.col(0).dot(residual) / x.col(0).squaredNorm();
      candidate->context.nonlinear[0] =
          std::clamp(coefficient, effect.nonlinear[0].low, effect.nonlinear[0].high);
    }
  } else {
    std::vector<double> low, high;
    for (std::size_t i = 0; i < effect.nonlinear.size(); ++i) {
      const NonlinearParameter& parameter = effect.nonlinear[i];
      const double at = candidate->context.nonlinear[i];
      if (effect.id == "bias.tone") {
        const double width = 1.0 / (problem_->end_s(problem_->rows() - 1) - problem_->begin_s(0));
        low.push_back(std::max(at - width, 1e-6));
        high.push_back(at + width);
      } else if (effect.id == "angle.ripple") {
        low.push_back(at - 0.5);
        high.push_back(at + 0.5);
      } else if (parameter.high > parameter.low) {
        low.push_back(parameter.low);
        high.push_back(parameter.high);
      }
    }
    if (low.size() != effect.nonlinear.size()) return;
    candidate->context.nonlinear =
        RefineNonlinear(columns, residual, candidate->context.nonlinear, low, high);
  }
  candidate->columns.clear();
}

// The best of the catalogue's grid and of the scans, whatever is more surprising.
bool Selection::AddBest() {
  const WhiteStore::Columns model = ModelColumns();
  const Candidate* best = nullptr;
  double best_excess = 0.0;
  for (const Candidate& candidate : pool_) {
    if (InModel(candidate.family)) continue;
    double gain = 0.0;
    double excess = candidate.log_level - LogP(candidate, model, &gain);
    if (excess <= 0.0) continue;
    excess -= 0.5 * Handicap(candidate);
    if (best != nullptr && excess <= best_excess) continue;
    best_excess = excess;
    best = &candidate;
  }
  std::optional<Candidate> chosen;
  if (best != nullptr) chosen = *best;
  const Eigen::VectorXd residual = Residual();
  const auto scanned = std::count_if(members_.begin(), members_.end(), [](const Candidate& member) {
    return member.effect != nullptr && member.family.find('@') != std::string::npos;
  });
  const std::vector<ScanPeak> peaks = scanned < kMostScanned
                                          ? Scan(*problem_, whitener_, store_.Take(model), residual)
                                          : std::vector<ScanPeak>{};
  for (const ScanPeak& peak : peaks) {
    const double level = std::log(options_.false_discovery * kShareOfScan / peak.tried);
    // The scan's own figure is rough: what comes near is worked out.
    if (peak.gain < 0.5 * ChiSquareQuantile(level, 2.0)) continue;
    Candidate candidate =
        ScannedCandidate(*problem_, peak.id, peak.table_axis, peak.nonlinear, peak.trail);
    candidate.log_level = level;
    if (InModel(candidate.family)) continue;
    const Eigen::Index mark = store_.used();
    candidate.columns = store_.Add(White(candidate));
    double gain = 0.0;
    double excess = level - LogP(candidate, model, &gain);
    if (excess > -kNearLevel && excess + kNearLevel > best_excess) {
      Refine(&candidate, model);
      if (candidate.columns.empty()) candidate.columns = store_.Add(White(candidate));
      excess = level - LogP(candidate, model, &gain);
    }
    if (excess <= best_excess) store_.DropFrom(mark);
    if (excess > best_excess) {
      best_excess = excess;
      chosen = candidate;
    }
  }
  if (!chosen) return false;
  if (chosen->refinable() || (chosen->effect != nullptr && chosen->effect->tied))
    Refine(&*chosen, model);
  Insert(std::move(*chosen));
  return true;
}

// One member for another of the catalogue that explains more.
bool Selection::Exchange() {
  bool changed = false;
  for (std::size_t i = 0; i < members_.size(); ++i) {
    const WhiteStore::Columns others = ModelWithout(i);
    double least = Cost(ModelColumns()) - 1.0;
    const Candidate* better = nullptr;
    for (const Candidate& candidate : pool_) {
      if (candidate.family == members_[i].family || InModel(candidate.family)) continue;
      WhiteStore::Columns with = others;
      with.insert(with.end(), candidate.columns.begin(), candidate.columns.end());
      const double cost = Cost(with) + Handicap(candidate) - Handicap(members_[i]);
      if (cost >= least) continue;
      least = cost;
      better = &candidate;
    }
    if (better == nullptr) continue;
    Candidate candidate = *better;
    if (candidate.refinable()) Refine(&candidate, others);
    members_.erase(members_.begin() + static_cast<std::ptrdiff_t>(i));
    Insert(std::move(candidate));
    changed = true;
  }
  return changed;
}

bool Selection::DropWeak() {
  bool changed = false;
  for (bool again = true; again;) {
    again = false;
    std::size_t weakest = members_.size();
    double lack = 0.0;
    for (std::size_t i = 0; i < members_.size(); ++i) {
      double gain = 0.0;
      const double over = LogP(members_[i], ModelWithout(i), &gain) - members_[i].log_level;
      if (over <= lack) continue;
      lack = over;
      weakest = i;
    }
    if (weakest == members_.size()) break;
    members_.erase(members_.begin() + static_cast<std::ptrdiff_t>(weakest));
    changed = again = true;
  }
  return changed;
}

bool Selection::AddComposed() {
  const double level = std::log(options_.false_discovery * kShareOfProducts /
                                static_cast<double>(std::max<std::size_t>(products_.size(), 1)));
  const Eigen::MatrixXd model = store_.Take(ModelColumns());
  const Eigen::LDLT<Eigen::MatrixXd> factor(model.transpose() * model);
  const Eigen::VectorXd residual = Residual();
  const Candidate* best = nullptr;
  double best_excess = 0.0;
  for (const Candidate& product : products_) {
    if (InModel(product.family)) continue;
    const Eigen::VectorXd column = White(product);
    if (!column.allFinite()) continue;
    const Eigen::VectorXd shared = model.transpose() * column;
    const double whole = column.squaredNorm();
    const double left = whole - shared.dot(factor.solve(shared));
    if (!(left > kAbsorbed * whole)) continue;
    const double excess = level - LogChiSquareTail(std::pow(column.dot(residual), 2) / left, 1.0);
    if (excess <= best_excess) continue;
    best_excess = excess;
    best = &product;
  }
  if (best == nullptr) return false;
  Candidate candidate = *best;
  candidate.log_level = level;
  Insert(std::move(candidate));
  return true;
}

// Until nothing is added that stays: what was dropped again would be added again.
void Selection::Grow(bool (Selection::*add)()) {
  for (std::size_t i = 0; i < 2 * kMostEffects && members_.size() < kMostEffects; ++i) {
    const std::multiset<std::string> before = Families();
    if (!(this->*add)()) return;
    Exchange();
    DropWeak();
    if (Families() == before) return;
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
    Grow(&Selection::AddBest);
    Grow(&Selection::AddComposed);
    if (Families() == before) break;
  }
}

double Selection::PValue(std::size_t member) const {
  double gain = 0.0;
  const Candidate& candidate = members_[member];
  const double log_p = LogP(candidate, ModelWithout(member), &gain);
  return std::min(1.0, std::exp(log_p - candidate.log_level) * options_.false_discovery);
}

std::vector<std::string> Selection::Rivals(std::size_t member) const {
  const WhiteStore::Columns others = ModelWithout(member);
  const double mine = Cost(ModelColumns());
  std::set<std::string> names;
  for (const Candidate& candidate : pool_) {
    if (candidate.id == members_[member].id || InModel(candidate.family)) continue;
    WhiteStore::Columns with = others;
    with.insert(with.end(), candidate.columns.begin(), candidate.columns.end());
    if (Cost(with) - mine < kRivalGain) names.insert(candidate.id);
  }
  return {names.begin(), names.end()};
}

Eigen::VectorXd Selection::Residual() const {
  const Eigen::MatrixXd model = store_.Take(ModelColumns());
  const WhiteStore::Solution solution = store_.Solve(ModelColumns());
  return store_.output() - model * solution.coefficients;
}

}  // namespace gyrobench::calibration
