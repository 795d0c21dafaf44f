#include "calibration/hold/estimate_noise.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <boost/math/distributions/chi_squared.hpp>
#include <boost/math/distributions/normal.hpp>
#include <boost/random/sobol.hpp>
#include <cmath>
#include <cstdint>
#include <vector>

#include "calibration/gls/minimize.h"

namespace gyrobench::calibration {
namespace {

using Eigen::Index;
using Logs = Eigen::Vector4d;

constexpr double kUsualAngleWalk_deg_sqrt_s = 3.5e-3;
constexpr double kUsualBiasWalk_deg_s_sqrt_s = 1e-4;
constexpr double kUsualStillness = 2.0;
const double kPriorWidth = std::log(4.0);

double Square(double value) { return value * value; }

// Logarithms of angle random walk, bias random walk, scatter from pose to pose, stillness.
Logs LogsOf(const HoldNoise& noise) {
  return Logs(noise.angle_random_walk_deg_sqrt_s, noise.bias_random_walk_deg_s_sqrt_s,
              noise.pose_scatter_g, noise.stillness)
      .array()
      .log();
}

HoldNoise At(const Logs& logs, const HoldNoise& start) {
  HoldNoise noise = start;
  noise.angle_random_walk_deg_sqrt_s = std::exp(logs[0]);
  noise.bias_random_walk_deg_s_sqrt_s = std::exp(logs[1]);
  noise.pose_scatter_g = std::exp(logs[2]);
  noise.stillness = std::exp(logs[3]);
  return noise;
}

double Prior(const HoldNoise& noise) {
  return Square(std::log(noise.angle_random_walk_deg_sqrt_s /
                         noise.usual_angle_random_walk_deg_sqrt_s) /
                kPriorWidth) +
         Square(std::log(noise.bias_random_walk_deg_s_sqrt_s / kUsualBiasWalk_deg_s_sqrt_s) /
                kPriorWidth) +
         Square(std::log(noise.stillness / kUsualStillness) / kPriorWidth);
}

double LogVariances(const LinearModel& model, const HoldNoise& noise) {
  double sum = 0.0;
  for (const HoldFactor& factor : model.factors)
    if (factor.used) sum += static_cast<double>(factor.rows) * std::log(VarianceOf(factor, noise));
  return sum;
}

// -2 log of the restricted likelihood, all unknowns integrated out (Patterson and Thompson 1971),
// and of the prior, at a solution:
//   sum of rows log v + log det H + residual^T V^-1 residual + prior.
// NaN where H is singular.
double Deviance(const LinearModel& model, const HoldNoise& noise,
                const ArrowSystem::Solution& solution) {
  if (!solution.positive) return kMissing;
  return LogVariances(model, noise) + solution.log_determinant + solution.residual_square +
         Prior(noise);
}

double DevianceAt(const LinearModel& model, const Logs& logs, const HoldNoise& start) {
  const HoldNoise noise = At(logs, start);
  return Deviance(model, noise, SolveModel(model, noise));
}

// Where the scatter from pose to pose is looked for about the accelerometer's density: far below
// it nothing shows.
constexpr double kLeastScatter = -6.0, kMostScatter = 5.0;
// The other logarithms about where they begin.
constexpr double kFarthest = 5.0;

}  // namespace

HoldNoise EstimateNoise(const LinearModel& model, const HoldNoise& start) {
  const auto deviance = [&](const std::vector<double>& logs) {
    return DevianceAt(model, Logs(logs.data()), start);
  };
  const double scatter = std::log(start.accel_density_g_sqrt_s);
  const Logs at = LogsOf(start);
  const std::vector<double> low = {at[0] - kFarthest, std::log(kUsualBiasWalk_deg_s_sqrt_s) - 5.0,
                                   scatter + kLeastScatter, std::log(kUsualStillness) - 4.0};
  const std::vector<double> high = {at[0] + kFarthest, std::log(kUsualBiasWalk_deg_s_sqrt_s) + 6.0,
                                    scatter + kMostScatter, std::log(kUsualStillness) + 4.0};
  const Minimum best = Minimize(deviance, {at.begin(), at.end()}, 0.7, low, high, 0.02, 250);
  return At(Logs(best.at.data()), start);
}

HoldNoise StartNoise(const RestNoise& rests) {
  HoldNoise noise;
  // Counts that stand still show none; then it is the turns' to say.
  noise.angle_random_walk_deg_sqrt_s = std::max(rests.angle_random_walk_deg_sqrt_s, 1e-4);
  // A tremble can only enlarge both.
  noise.usual_angle_random_walk_deg_sqrt_s = std::fmax(
      std::fmin(rests.white_angle_random_walk_deg_sqrt_s, rests.angle_random_walk_deg_sqrt_s),
      kUsualAngleWalk_deg_sqrt_s);
  noise.bias_random_walk_deg_s_sqrt_s = kUsualBiasWalk_deg_s_sqrt_s;
  noise.accel_density_g_sqrt_s = std::max(rests.accel_density_g_sqrt_s, 1e-6);
  noise.pose_scatter_g = 0.3 * noise.accel_density_g_sqrt_s;
  noise.stillness = kUsualStillness;
  return noise;
}

namespace {

// Weighted solutions at the noise that the data permit.
class OverNoise {
 public:
  OverNoise(const LinearModel& model, const HoldNoise& likeliest)
      : model_(model),
        likeliest_(likeliest),
        mode_(LogsOf(likeliest)),
        scatter_(std::log(likeliest.accel_density_g_sqrt_s)) {
    mode_[2] = std::clamp(mode_[2], scatter_ + kLeastScatter, scatter_ + kMostScatter);
  }

  Eigen::MatrixXd Covariance() {
    const ArrowSystem::Solution at_mode = SolveWithMeanOffset(model_, likeliest_);
    least_ = Deviance(model_, likeliest_, at_mode);
    reported_ = at_mode.positive ? StepOf(at_mode) : Eigen::VectorXd();
    FindSpread();
    boost::random::sobol sequence(5);
    for (int i = 0; i < kPoints; ++i) {
      const Draw draw = Next(i == 0 ? nullptr : &sequence);
      if (!IsLookedAt(draw.logs)) continue;
      const HoldNoise noise = At(draw.logs, likeliest_);
      const ArrowSystem::Solution solution = SolveWithMeanOffset(model_, noise);
      Add(solution, -0.5 * (Deviance(model_, noise, solution) - least_) - draw.log_density);
    }
    if (points_.empty()) Add(at_mode, 0.0);
    return MeanSquare();
  }

 private:
  // Errors are within 2.4 % (root mean square) of those by 1024 points.
  static constexpr int kPoints = 128;
  static constexpr double kFreedom = 4.0;  // of the distribution that is drawn from
  static constexpr double kStep = 0.4;     // of the logarithms, for second differences
  static constexpr double kWidest = 2.0;   // standard deviation of a direction that data leave open

  struct Draw {
    Logs logs;
    double log_density = 0.0;  // over that at the mode
  };

  // Of the estimate about the one that is reported, by this noise.
  struct Point {
    double log_weight = 0.0;
    Eigen::MatrixXd square;
  };

  // Square root of the inverse of half the second derivatives of the deviance.
  void FindSpread() {
    Eigen::Matrix4d curvature;
    const auto moved = [&](Index i, double by_i, Index j, double by_j) {
      Logs logs = mode_;
      logs[i] += by_i * kStep;
      logs[j] += by_j * kStep;
      return DevianceAt(model_, logs, likeliest_);
    };
    for (Index i = 0; i < 4; ++i) {
      curvature(i, i) = moved(i, 1, i, 0) - 2.0 * least_ + moved(i, -1, i, 0);
      for (Index j = 0; j < i; ++j)
        curvature(i, j) = curvature(j, i) = 0.25 * (moved(i, 1, j, 1) - moved(i, 1, j, -1) -
                                                    moved(i, -1, j, 1) + moved(i, -1, j, -1));
    }
    curvature /= 2.0 * kStep * kStep;
    if (!curvature.allFinite()) curvature.setIdentity();
    const Eigen::SelfAdjointEigenSolver<Eigen::Matrix4d> parts(curvature);
    spread_ = parts.eigenvectors() * parts.eigenvalues()
                                         .cwiseMax(1.0 / (kWidest * kWidest))
                                         .cwiseSqrt()
                                         .cwiseInverse()
                                         .asDiagonal();
  }

  // The next point of the sequence; its first, zero, where none is given. Each in the middle of its
  // share of the unit interval.
  Draw Next(boost::random::sobol* sequence) const {
    const auto uniform = [&] {
      const double value =
          sequence == nullptr ? 0.0 : std::ldexp(static_cast<double>((*sequence)()), -64);
      return value + 0.5 / kPoints;
    };
    Logs z;
    for (Index i = 0; i < 4; ++i) z[i] = boost::math::quantile(boost::math::normal(), uniform());
    const double chi2 = boost::math::quantile(boost::math::chi_squared(kFreedom), uniform());
    z *= std::sqrt(kFreedom / chi2);
    return {mode_ + spread_ * z, -0.5 * (kFreedom + 4.0) * std::log1p(z.squaredNorm() / kFreedom)};
  }

  // As EstimateNoise looks for it.
  bool IsLookedAt(const Logs& logs) const {
    return (logs - mode_).cwiseAbs().maxCoeff() <= kFarthest &&
           logs[2] >= scatter_ + kLeastScatter && logs[2] <= scatter_ + kMostScatter;
  }

  static Eigen::VectorXd StepOf(const ArrowSystem::Solution& solution) {
    Eigen::VectorXd step(solution.parameters.size() + 3);
    step << solution.parameters, MeanOffsetOf(solution);
    return step;
  }

  void Add(const ArrowSystem::Solution& solution, double log_weight) {
    if (!solution.positive || !std::isfinite(log_weight) || reported_.size() == 0) return;
    const Eigen::VectorXd step = StepOf(solution) - reported_;
    points_.push_back({log_weight, solution.covariance + step * step.transpose()});
  }

  Eigen::MatrixXd MeanSquare() const {
    const Index size = model_.extent.Parameters() + 3;
    if (points_.empty()) return Eigen::MatrixXd::Constant(size, size, kMissing);
    double most = points_.front().log_weight, weights = 0.0;
    for (const Point& point : points_) most = std::max(most, point.log_weight);
    Eigen::MatrixXd sum = Eigen::MatrixXd::Zero(size, size);
    for (const Point& point : points_) {
      const double weight = std::exp(point.log_weight - most);
      weights += weight;
      sum += weight * point.square;
    }
    return sum / weights;
  }

  const LinearModel& model_;
  const HoldNoise& likeliest_;
  Logs mode_;
  double scatter_ = 0.0, least_ = 0.0;
  Eigen::Matrix4d spread_;
  Eigen::VectorXd reported_;
  std::vector<Point> points_;
};

}  // namespace

Eigen::MatrixXd CovarianceOverNoise(const LinearModel& model, const HoldNoise& noise) {
  return OverNoise(model, noise).Covariance();
}

}  // namespace gyrobench::calibration
