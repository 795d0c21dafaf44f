#include "calibration/hold/hold_noise.h"

#include <cmath>
#include <vector>

#include "base/angle_unit.h"
#include "calibration/gls/minimize.h"

namespace gyrobench::calibration {
namespace {

constexpr double kUsualAngleWalk = 3.5e-3 * kRadPerDeg;
constexpr double kUsualBiasWalk = 1e-4 * kRadPerDeg;
constexpr double kUsualStillness = 2.0;
const double kPriorWidth = std::log(4.0);

double Square(double value) { return value * value; }

HoldNoise At(const std::vector<double>& logs, const HoldNoise& start) {
  HoldNoise noise = start;
  noise.angle_random_walk = std::exp(logs[0]);
  noise.bias_random_walk = std::exp(logs[1]);
  noise.pose_scatter_g = std::exp(logs[2]);
  noise.stillness = std::exp(logs[3]);
  return noise;
}

double Prior(const HoldNoise& noise) {
  return Square(std::log(noise.angle_random_walk / kUsualAngleWalk) / kPriorWidth) +
         Square(std::log(noise.bias_random_walk / kUsualBiasWalk) / kPriorWidth) +
         Square(std::log(noise.stillness / kUsualStillness) / kPriorWidth);
}

}  // namespace

double RestrictedDeviance(const LinearModel& model, const HoldNoise& noise) {
  double deviance = 0.0;
  for (const Factor& factor : model.factors)
    if (factor.used)
      deviance += static_cast<double>(factor.rows) * std::log(VarianceOf(factor, noise));
  const ArrowSystem::Solution solution = SolveModel(model, noise);
  if (!solution.positive) return kMissing;
  return deviance + solution.log_determinant + solution.residual_square;
}

HoldNoise EstimateNoise(const LinearModel& model, const HoldNoise& start) {
  const auto deviance = [&](const std::vector<double>& logs) {
    const HoldNoise noise = At(logs, start);
    return RestrictedDeviance(model, noise) + Prior(noise);
  };
  const double scatter = std::log(start.accel_density);
  const std::vector<double> at = {std::log(start.angle_random_walk),
                                  std::log(start.bias_random_walk), std::log(start.pose_scatter_g),
                                  std::log(start.stillness)};
  const std::vector<double> low = {at[0] - 5.0, std::log(kUsualBiasWalk) - 5.0, scatter - 6.0,
                                   std::log(kUsualStillness) - 4.0};
  const std::vector<double> high = {at[0] + 5.0, std::log(kUsualBiasWalk) + 6.0, scatter + 5.0,
                                    std::log(kUsualStillness) + 4.0};
  const Minimum best = Minimize(deviance, at, 0.7, low, high, 0.02, 250);
  return At(best.at, start);
}

HoldNoise StartNoise(const RestNoise& rests) {
  HoldNoise noise;
  // Counts that stand still show none; then it is the turns' to say.
  noise.angle_random_walk = std::max(rests.angle_random_walk, 1e-4 * kRadPerDeg);
  noise.bias_random_walk = kUsualBiasWalk;
  noise.accel_density = std::max(rests.accel_density, 1e-6);
  noise.pose_scatter_g = 0.3 * noise.accel_density;
  noise.stillness = kUsualStillness;
  return noise;
}

}  // namespace gyrobench::calibration
