#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <utility>
#include <vector>

#include "calibration/gls/scaled_ldlt.h"
#include "calibration/trace/report_parts.h"
#include "calibration/trace/selection.h"

namespace gyrobench::calibration {
namespace {

std::string WhatIsMissing(unsigned lacks) {
  if ((lacks & kNeedsRate) != 0) return "there is no motion about this axis";
  if ((lacks & kNeedsGravity) != 0) return "gravity in the sensor's frame is not known";
  if ((lacks & kNeedsTemperature) != 0) return "temperature is missing or does not change";
  if ((lacks & kNeedsTableAxis) != 0) return "no angle of a table's axis is given";
  if ((lacks & kNeedsVibration) != 0)
    return "no accelerometer feels the vibration, with four samples and more in a tenth of a "
           "second";
  if ((lacks & kNeedsGear) != 0) return "the gear between shaft and table is not stated";
  return "nothing says when the sensor was switched on";
}

// The grid point of an effect that the measurements see best: least absorbed, and its bound.
struct Observability {
  double left = 0.0;  // of a term's square, the largest
  double bound = std::numeric_limits<double>::infinity();
};

// White columns of a candidate with all its terms; in the store those that these data are blind to
// are 0.
Eigen::MatrixXd AllTerms(const Selection& selection, const Candidate& candidate) {
  const Eigen::MatrixXd stored = selection.store().Take(candidate.columns);
  return stored.colwise().any().all() ? stored : selection.White(candidate);
}

// Of every effect that was looked for, by its name.
std::map<std::string, Observability> ObservabilityOf(const Selection& selection) {
  // Columns that the baseline is taken off together, which reads it once.
  constexpr Eigen::Index kTogether = 32;
  std::map<std::string, Observability> out;
  const Projection baseline(selection.store().Take(selection.ColumnsOfSensor()));
  Eigen::MatrixXd places(selection.store().rows(), kTogether);
  std::vector<Observability*> of;  // of each column
  auto look = [&] {
    const Eigen::MatrixXd white = places.leftCols(static_cast<Eigen::Index>(of.size()));
    const Eigen::MatrixXd left = baseline.Off(white);
    for (Eigen::Index j = 0; j < white.cols(); ++j) {
      Observability& observability = *of[static_cast<std::size_t>(j)];
      const double whole = white.col(j).squaredNorm(), square = left.col(j).squaredNorm();
      if (whole > 0) observability.left = std::max(observability.left, square / whole);
      if (square > 0) observability.bound = std::min(observability.bound, 1.0 / std::sqrt(square));
    }
    of.clear();
  };
  for (const std::vector<Candidate>* list : {&selection.pool(), &selection.unseen()}) {
    for (const Candidate& candidate : *list) {
      if (candidate.effect == nullptr) continue;
      const Eigen::MatrixXd terms = AllTerms(selection, candidate);
      if (static_cast<Eigen::Index>(of.size()) + terms.cols() > places.cols()) look();
      if (terms.cols() > places.cols()) places.resize(Eigen::NoChange, terms.cols());
      places.middleCols(static_cast<Eigen::Index>(of.size()), terms.cols()) = terms;
      of.resize(of.size() + static_cast<std::size_t>(terms.cols()), &out[candidate.id]);
    }
  }
  look();
  return out;
}

Unidentifiable Because(std::string reason) {
  Unidentifiable unseen;
  unseen.because = std::move(reason);
  return unseen;
}

// Why these data cannot show an effect that was looked for; no reason where they can.
Unidentifiable WhyUnseen(const Effect& effect, const Observability& observability) {
  if (observability.left < Selection::kAbsorbed)
    return Because("the baseline explains it just as well (absorbed)");
  if (!(effect.typical_size > 0) || observability.bound <= effect.typical_size) return {};
  const std::string& unit = effect.terms[0].unit;
  Unidentifiable unseen = Because(
      fmt::format("its bound here, {:.2g} {}, is beyond the largest size of such parts, {:.2g}",
                  observability.bound, unit, effect.typical_size));
  unseen.limit = {observability.bound, effect.typical_size, unit};
  return unseen;
}

// Of a coarse encoder.
void ListRounding(const ChannelProblem& problem, std::vector<Unidentifiable>* out) {
  if (!(problem.rounding_deg() > 0.0) || problem.table_axes().empty()) return;
  out->push_back(
      {ScannedEffect(Search::kPeriods, EffectDomain::kAngle).id,
       fmt::format(
           "the steps of the encoder are coarser than its noise: their rounding is "
           "a ripple of the angle itself; waves of less than {:.1g} deg are told from it only "
           "by turns at speeds at which rounding makes none of their period",
           problem.rounding_deg()),
       "take an encoder of finer steps"});
}

constexpr std::int64_t kLeastClockPairs = 10;
// Of a reference without a second one beside it.
void ListAlwaysUnseen(const ChannelProblem& problem, std::vector<Unidentifiable>* out) {
  if ((problem.observables() & kNeedsRate) == 0) return;
  const bool two_clocks = std::ranges::any_of(problem.histories(), [](const StateHistory& history) {
    return history.recording->ticks.count() >= kLeastClockPairs;
  });
  for (const NeverSeen& effect : NeverSeenEffects()) {
    if (effect.seen_by_host_clock && two_clocks) continue;
    out->push_back({effect.id, effect.because, effect.settled_by});
  }
}

}  // namespace

std::vector<Unidentifiable> Unidentifiables(const ChannelProblem& problem,
                                            const Selection& selection,
                                            const std::set<std::string>& named,
                                            bool earth_rate_known) {
  const std::map<std::string, Observability> seen = ObservabilityOf(selection);
  std::vector<Unidentifiable> out;
  std::set<std::string> listed;
  const auto list = [&](const std::string& id, Unidentifiable unseen) {
    if (unseen.because.empty() || named.contains(id) || !listed.insert(id).second) return;
    unseen.id = id;
    unseen.settled_by = ManoeuvreOf(id);
    out.push_back(std::move(unseen));
  };
  // As if every row had what they depend on.
  for (const Candidate& candidate :
       CatalogueCandidates(problem, selection.covariates(), earth_rate_known)) {
    const auto observability = seen.find(candidate.id);
    list(candidate.id,
         observability != seen.end()
             ? WhyUnseen(*candidate.effect, observability->second)
             : Because("what it depends on is not known all the time: not looked for"));
  }
  for (const Effect& effect : EffectCatalogue()) {
    const bool grid = effect.nonlinear.empty() || !effect.nonlinear[0].grid.empty();
    const unsigned lacks = effect.needs & ~problem.observables();
    if (!grid || (effect.needs & kNeedsCovariate) != 0 || lacks == 0) continue;
    if (effect.true_motion && earth_rate_known) continue;
    list(effect.id, Because(WhatIsMissing(lacks)));
  }
  ListRounding(problem, &out);
  ListAlwaysUnseen(problem, &out);
  return out;
}

}  // namespace gyrobench::calibration
