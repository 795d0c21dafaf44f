// What may be added to a model: points of the grid and what lies between them, what scans find,
// ramps and products.
#include <algorithm>
#include <cmath>
#include <map>
#include <optional>
#include <utility>

#include "calibration/gls/independent_columns.h"
#include "calibration/gls/ramp_search.h"
#include "calibration/gls/robust_gain.h"
#include "calibration/gls/scaled_ldlt.h"
#include "calibration/gls/statistics.h"
#include "calibration/trace/scans.h"
#include "calibration/trace/selection.h"

namespace gyrobench::calibration {
namespace {

// A scan's place, or a point of a grid, so near to its level may pass it when it is refined.
constexpr double kNearLevel = 4.0;
// Logarithm of how much more often, for each parameter that is refined: at the gains that are asked
// for, by the tails of chi square with one degree more and the width of a cell of the grid.
constexpr double kBetweenPoints = 0.85;
// Many steps and tones are no cause but a residual that is not understood.
constexpr std::ptrdiff_t kMostScanned = 6;
// Of what the baseline leaves of a column: with less beside the members its error is over ten times
// what it is without them.
constexpr double kToldApart = 0.01;

// By more than two that short rests cannot tell apart differ.
bool IsFasterTone(const ScanPeak& peak, const std::optional<Candidate>& than) {
  constexpr double kFaster = 1.2;
  return than && than->search() == Search::kFrequency &&
         peak.effect->search == Search::kFrequency &&
         peak.nonlinear > kFaster * than->context.nonlinear[0];
}

}  // namespace

void Selection::TryPool(const WhiteStore::Columns& model, Best* best) {
  for (const Candidate& candidate : pool_) {
    if (Barred(candidate.family) || InAnotherShape(candidate)) continue;
    double evidence_margin = candidate.log_level - LogP(candidate, model);
    if (evidence_margin <= 0.0) continue;
    evidence_margin = std::max(evidence_margin - 0.5 * candidate.complexity_penalty(), 1e-9);
    if (evidence_margin <= best->evidence_margin || !Plausible(candidate, model)) continue;
    *best = {candidate, evidence_margin};
  }
  if (best->candidate) return;
  for (const Candidate* point : NearlyFound(model)) TryBetween(*point, model, best);
}

// Two shapes of one thing: each may stand for both, and not beside the other. So are a stand that
// shakes with the speed of any axis and one that does with the channel's own; and a delay and a lag
// of first order where the shape of the filter is free, as beside a declared delay.
bool Selection::InAnotherShape(const Candidate& candidate, std::size_t without) const {
  if (candidate.effect == nullptr) return false;
  const bool of_filter = problem_->DelayIsDeclared() && candidate.effect->filter_shape;
  for (std::size_t i = 0; i < members_.size(); ++i) {
    const Effect* effect = members_[i].effect;
    if (i == without || effect == nullptr) continue;
    if (effect == candidate.effect) {
      if (candidate.context.of_stand != members_[i].context.of_stand) return true;
    } else if (of_filter && effect->filter_shape) {
      return true;
    }
  }
  return false;
}

// Of each family whose parameters are searched for, the point that comes nearest to its level.
std::vector<const Candidate*> Selection::NearlyFound(const WhiteStore::Columns& model) const {
  std::map<std::string, std::pair<double, const Candidate*>> nearest;
  for (const Candidate& candidate : pool_) {
    if (!candidate.searched() || Barred(candidate.family) || InAnotherShape(candidate)) continue;
    const double evidence_margin = candidate.log_level - LogP(candidate, model);
    auto [place, first] = nearest.try_emplace(candidate.family, evidence_margin, &candidate);
    if (!first && evidence_margin > place->second.first)
      place->second = {evidence_margin, &candidate};
  }
  std::vector<const Candidate*> out;
  for (const auto& [family, point] : nearest) {
    if (point.first >= -kNearLevel) out.push_back(point.second);
  }
  return out;
}

// What is nearly there at a point of its grid may be there between the points. The best of all
// places between passes a level more often than the points do, which were counted.
void Selection::TryBetween(Candidate candidate, const WhiteStore::Columns& model, Best* best) {
  candidate.log_level -= kBetweenPoints * static_cast<double>(candidate.context.nonlinear.size());
  const Eigen::Index mark = store_.used();
  Refine(&candidate, model);
  Place(&candidate);
  const double evidence_margin = candidate.log_level - LogP(candidate, model);
  if (evidence_margin > best->evidence_margin && Plausible(candidate, model)) {
    *best = {std::move(candidate), evidence_margin, true};
  } else {
    store_.DropFrom(mark);
  }
}

// What a scan finds at nearly the place of another find, or of what a member does, can be as large
// as one likes against it, and describes a single reading.
bool Selection::ToldFromMembers(const Candidate& candidate,
                                const WhiteStore::Columns& model) const {
  return std::ranges::all_of(candidate.columns, [&](Eigen::Index column) {
    return store_.Left(column, model) > kToldApart * store_.Left(column, base_);
  });
}

void Selection::TryScans(const WhiteStore::Columns& model, Best* best) {
  const auto scanned = std::count_if(members_.begin(), members_.end(),
                                     [](const Candidate& member) { return member.scanned(); });
  if (scanned >= kMostScanned) return;
  constexpr double kFarLess = 2.0, kClearlyAhead = 5.0;
  const Eigen::Index begin = store_.used();
  const SingleReadings readings = {within_, ResidualOfReadings(model)};
  for (const ScanPeak& peak :
       Scan(*problem_, whitener_, store_.Take(model), Residual(), readings)) {
    // A tone that few rests show takes the place of what explains far less alone.
    const double behind = peak.last_resort && best->candidate ? kFarLess : 1.0;
    // Slower tones come first; one that the rows show as well as a faster one stays.
    const double ahead = IsFasterTone(peak, best->candidate) ? kClearlyAhead : 0.0;
    // By the count of tests at the scan's own gain, which is not counted again when the noise is
    // estimated anew: a step's neighbours differ the more, the larger the gain is.
    // There is a scan of ripples for each axis.
    const bool of_axis = peak.effect->search == Search::kPeriods;
    const auto scans = static_cast<double>(of_axis ? problem_->table_axes().size() : 1);
    const double level = log_level_of_id_ - std::log(scans * peak.tried);
    if (!peak.ComesNear(level)) continue;
    Candidate candidate = ScannedCandidate(*problem_, peak);
    candidate.log_level = level;
    candidate.tail_freedom = peak.tail_freedom;
    if (Barred(candidate.family)) continue;
    if (candidate.search() == Search::kTime) PlaceStep(model, &candidate);
    const Eigen::Index mark = store_.used();
    Store(&candidate);
    double evidence_margin = level - LogP(candidate, model);
    const bool near =
        evidence_margin > -kNearLevel && evidence_margin + kNearLevel > best->evidence_margin;
    // What rounding makes of a whole number of periods it makes of those beside it.
    if (near && of_axis && !Plausible(candidate, model)) {
      store_.DropFrom(mark);
      continue;
    }
    if (near) {
      // Refinement goes by the nodes alone.
      const Candidate unrefined = candidate;
      const double before = evidence_margin;
      Refine(&candidate, model);
      Place(&candidate);
      evidence_margin = level - LogP(candidate, model);
      if (evidence_margin < before) {
        candidate = unrefined;
        evidence_margin = before;
      }
    }
    if (evidence_margin > behind * best->evidence_margin + ahead &&
        ToldFromMembers(candidate, model) && Plausible(candidate, model)) {
      if (mark > begin) {  // in the place of the best before
        store_.DropFrom(begin);
        Store(&candidate);
      }
      *best = {candidate, evidence_margin, true};
    } else {
      store_.DropFrom(mark);
    }
  }
}

// The best ramp of each quantity that curves are sought in.
std::vector<Selection::Ramp> Selection::BestRamps(const WhiteStore::Columns& model) const {
  std::vector<Ramp> out;
  for (std::size_t f = 0; f < cells_.size(); ++f) {
    const CurveCells& cells = candidates_->cells[f];
    const RampPeak peak = SearchRamps(store_.RemainderOf(cells_[f], model));
    if (!(peak.gain > 0.0)) continue;
    out.push_back(
        {EmpiricalCandidate(*problem_, cells.factor, cells.edges[peak.from], cells.edges[peak.to]),
         peak.gain, peak.tried * static_cast<double>(cells_.size())});
    out.back().candidate.log_level =
        std::log(options_.false_discovery * kShareOfCurves / out.back().tried);
  }
  return out;
}

void Selection::TryRamps(const WhiteStore::Columns& model, Best* best) const {
  for (Ramp& ramp : BestRamps(model)) {
    double evidence_margin = ramp.candidate.log_level - LogChiSquareTail(ramp.gain, 1.0);
    if (evidence_margin <= 0.0 || Barred(ramp.candidate.family)) continue;
    evidence_margin = std::max(evidence_margin - 0.5 * ramp.candidate.complexity_penalty(), 1e-9);
    if (evidence_margin > best->evidence_margin)
      *best = {std::move(ramp.candidate), evidence_margin};
  }
}

// A product must be clearly ahead, and by what a description costs: the others may still be
// refined.
void Selection::TryProducts(Best* best) const {
  constexpr double kClearly = 1.1;
  std::vector<const Candidate*> open;
  for (const Candidate& product : candidates_->products) {
    if (!Barred(product.family)) open.push_back(&product);
  }
  if (open.empty()) return;
  Eigen::MatrixXd columns(problem_->rows(), static_cast<Eigen::Index>(open.size()));
  std::vector<RawColumns> raw;
  for (const Candidate* product : open) raw.push_back(*product->raw);
  whitener_.Whiten(raw, columns);
  const Eigen::VectorXd whole = columns.colwise().squaredNorm();
  const WhiteStore::Columns beside = BesideShapes(ModelColumns());
  const Eigen::MatrixXd model = store_.Take(beside);
  const Eigen::MatrixXd gram = store_.Products(beside), shares = model.transpose() * columns;
  columns = Projection(model).Off(columns);
  const Eigen::VectorXd residual = Residual();
  const double level = std::log(options_.false_discovery * kShareOfProducts /
                                static_cast<double>(candidates_->products.size()));
  // Most of a product that nearly does what turns do would stand for the scale factor, which no
  // part can have then.
  const auto moves_scale_factor = [&](Eigen::Index k, double size) {
    constexpr double kMost = 0.2;
    const double share = turns_itself_ ? SolveIndependent(gram, shares.col(k))(0) : 0.0;
    return std::fabs(size * share) > kMost * std::fabs(own_scale_);
  };
  Eigen::Index chosen = -1;
  double most = kClearly * best->evidence_margin;
  if (best->candidate) most += 0.5 * open.front()->complexity_penalty();
  for (Eigen::Index k = 0; k < columns.cols(); ++k) {
    const double left = columns.col(k).squaredNorm();
    if (!(left > kAbsorbed * whole(k))) {
      columns.col(k).setZero();
      continue;
    }
    const double size = columns.col(k).dot(residual) / left;
    const double gain = std::max(size * size * left - LeftByShapes(), 0.0);
    const double evidence_margin = level - LogChiSquareTail(gain, 1.0);
    if (evidence_margin <= most) continue;
    if (moves_scale_factor(k, size)) {
      columns.col(k).setZero();
      continue;
    }
    most = evidence_margin;
    chosen = k;
  }
  if (chosen < 0 || !StaysBest(columns, residual, chosen)) return;
  *best = {*open[static_cast<std::size_t>(chosen)], most};
  best->candidate->log_level = level;
}

}  // namespace gyrobench::calibration
