#include "calibration/trace/unidentifiable.h"

#include <fmt/format.h>

#include <Eigen/Cholesky>
#include <cmath>
#include <limits>
#include <map>

namespace gyrobench::calibration {
namespace {

constexpr double kAbsorbed = 1e-6;

std::string WhatIsMissing(unsigned lacks) {
  if ((lacks & kNeedsRate) != 0) return "there is no motion about this axis";
  if ((lacks & kNeedsGravity) != 0) return "gravity in the sensor's frame is not known";
  if ((lacks & kNeedsTemperature) != 0) return "temperature is missing or does not change";
  if ((lacks & kNeedsTableAxis) != 0) return "no angle of a table's axis is given";
  return "there is no accelerometer to feel the vibration";
}

// The grid point of a family that the measurements see best: least absorbed, and its bound.
struct Sight {
  double left = 0.0;  // of a term's square, the largest
  double bound = std::numeric_limits<double>::infinity();
};

}  // namespace

std::vector<Unidentifiable> Unidentifiables(const ChannelProblem& problem,
                                            const Selection& selection,
                                            const std::set<std::string>& named,
                                            bool earth_rate_known) {
  std::map<std::string, Sight> seen;
  const WhiteStore& store = selection.store();
  const Eigen::MatrixXd base = store.Take(selection.baseline_columns());
  const Eigen::LDLT<Eigen::MatrixXd> factor(base.transpose() * base);
  auto look = [&](const Candidate& candidate) {
    if (candidate.effect == nullptr) return;
    Sight& sight = seen[candidate.effect->id];
    const Eigen::MatrixXd white = selection.White(candidate);
    for (Eigen::Index j = 0; j < white.cols(); ++j) {
      const Eigen::VectorXd shared = base.transpose() * white.col(j);
      const double whole = white.col(j).squaredNorm();
      const double square = std::max(whole - shared.dot(factor.solve(shared)), 0.0);
      if (whole > 0) sight.left = std::max(sight.left, square / whole);
      if (square > 0) sight.bound = std::min(sight.bound, 1.0 / std::sqrt(square));
    }
  };
  for (const Candidate& candidate : selection.pool()) look(candidate);
  for (const Candidate& candidate : selection.unseen()) look(candidate);
  std::vector<Unidentifiable> out;
  std::set<std::string> listed;
  for (const Effect& effect : EffectCatalogue()) {
    const bool grid = effect.nonlinear.empty() || !effect.nonlinear[0].grid.empty();
    if (!grid || (effect.needs & kNeedsCovariate) != 0 || named.contains(effect.id)) continue;
    if (effect.id == "bias.earth_rate" && earth_rate_known) continue;
    if (seen.contains(effect.id) && listed.contains(effect.id)) continue;
    const unsigned lacks = effect.needs & ~problem.knows();
    std::string because;
    const auto found = seen.find(effect.id);
    if (found == seen.end()) {
      if (lacks == 0) continue;
      because = WhatIsMissing(lacks);
    } else if (found->second.left < kAbsorbed) {
      because = "the baseline explains it just as well (absorbed)";
    } else if (effect.typical_size > 0 && found->second.bound > effect.typical_size) {
      because =
          fmt::format("its bound here, {:.2g} {}, is beyond the largest size of such parts, {:.2g}",
                      found->second.bound, effect.terms[0].unit, effect.typical_size);
    } else {
      continue;
    }
    if (!listed.insert(effect.id).second) continue;
    out.push_back({effect.id, because, effect.manoeuvre});
  }
  if ((problem.knows() & kNeedsRate) != 0) {
    out.push_back({"angle.reference_scale",
                   "a scale error of the reference and one of the gyro are the same in these data",
                   "close a full turn against an index mark, or tilt the axis so that the "
                   "accelerometer sees gravity turn by the true angle"});
    if (problem.trails().front().recording->ticks.count() < 10) {
      out.push_back({"time.rate",
                     "an error of the time base and one of the gyro's scale are the same in these "
                     "data",
                     "record the host's clock next to the sensor's"});
    }
  }
  return out;
}

}  // namespace gyrobench::calibration
