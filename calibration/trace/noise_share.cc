#include "calibration/trace/noise_share.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <utility>

#include "calibration/gls/noise_search.h"
#include "calibration/trace/candidate.h"

namespace gyrobench::calibration {
namespace {

// The least of a curve through a share and its neighbours, a factor apart, in the logarithm; the
// share itself where they do not say.
double Between(const std::array<double, 3>& deviance, double factor) {
  const double bend = deviance[0] - 2.0 * deviance[1] + deviance[2];
  const double shift =
      bend > 0.0 && std::isfinite(bend) ? 0.5 * (deviance[0] - deviance[2]) / bend : 0.0;
  return std::pow(factor, std::clamp(shift, -0.5, 0.5));
}

}  // namespace

NoiseShare BestShare(const RowsWithShare& with, std::span<const RawColumns> columns,
                     const Eigen::VectorXd& output_deg, const std::optional<NoiseModel>& from,
                     double least_gain) {
  constexpr double kLeastShare = 1.0 / 64.0, kMostShare = 64.0, kFactor = 4.0;
  constexpr double kRough = 0.1;  // of the logarithms of the noise's ratios
  struct Tried {
    double share = 0.0, deviance = std::numeric_limits<double>::infinity();
    std::optional<NoiseModel> noise;
  };
  const auto try_from = [&](const Tried& last, double share) -> Tried {
    // Likelihoods that are restricted by other columns cannot be compared: none is left out.
    const NoiseSearch search(with(share), columns, output_deg, kNearlyDependent);
    const std::optional<NoiseEstimate> best = search.Best(last.noise, kRough);
    if (!best) return {share, std::numeric_limits<double>::infinity(), last.noise};
    return {share, best->deviance, best->noise};
  };
  const Tried none = try_from({0.0, 0.0, from}, 0.0);
  if (!std::isfinite(none.deviance)) return {0.0, from};
  Tried before = none, here = none, after = try_from(none, kLeastShare);
  while (after.deviance < here.deviance) {
    before = std::exchange(here, after);
    if (!(here.share < kMostShare)) break;
    after = try_from(here, kFactor * here.share);
  }
  if (!(here.deviance < none.deviance - least_gain)) return {0.0, none.noise};
  // No share is no factor below the least.
  const bool between = before.share > 0.0 && after.share > here.share;
  return {between ? here.share * Between({before.deviance, here.deviance, after.deviance}, kFactor)
                  : here.share,
          here.noise};
}

}  // namespace gyrobench::calibration
