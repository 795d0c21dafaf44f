// Laws of the noise of held poses: what the highest frequencies show of it, and intervals that hold
// although few turns tell it.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <Eigen/Core>
#include <cmath>
#include <random>

#include "calibration/hold/epoch_collector.h"
#include "calibration/hold/estimate_noise.h"

namespace gyrobench::calibration {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::Vector3d;

// Of white noise of each sample and a tremble at 8 Hz, with a gap where asked for [deg/sqrt(s)].
double WhiteDensity(double rate_hz, double noise_deg_s, double tremble_deg_s, bool gap) {
  EpochCollector collector;
  MeasurementInfo info;
  info.gyro_unit = RateUnit::kDegPerSecond;
  info.gyro_present = info.accel_present = {true, true, true};
  collector.OnInfo(info);
  std::mt19937 random(11);
  std::normal_distribution<double> normal;
  for (int i = 0; i < 20000; ++i) {
    GyroSample sample;
    sample.t_s = i / rate_hz + (gap && i > 10000 ? 3.0 : 0.0);
    const double offset_deg_s = gap && i > 10000 ? 50.0 : 2.0;  // turned about while nobody looked
    for (double& xi : sample.xi)
      xi = offset_deg_s + noise_deg_s * normal(random) +
           tremble_deg_s * std::sin(6.283185307179586 * 8.0 * sample.t_s);
    sample.accel_g = {0.0, 0.0, 1.0};
    collector.OnGyro(sample);
  }
  double square = 0.0;
  int samples = 0;
  for (const Epoch& epoch : collector.Take().epochs) {
    square += epoch.white_square;
    samples += epoch.white_samples;
  }
  return std::sqrt(square / (3.0 * samples));
}

TEST(EpochCollector, SeesWhiteNoiseThroughATremble) {
  for (const double rate_hz : {100.0, 200.0, 1000.0}) {
    const double truth = 0.1 / std::sqrt(rate_hz);  // deg/sqrt(s) of white samples
    EXPECT_NEAR(WhiteDensity(rate_hz, 0.1, 0.0, false), truth, 0.03 * truth) << rate_hz;
    EXPECT_NEAR(WhiteDensity(rate_hz, 0.1, 5.0, false), truth, 0.03 * truth) << rate_hz;
    EXPECT_NEAR(WhiteDensity(rate_hz, 0.1, 5.0, true), truth, 0.03 * truth) << "across a gap";
    EXPECT_LT(WhiteDensity(rate_hz, 0.0, 5.0, false), 0.05 * truth) << "a tremble alone";
  }
}

// Rows as a recording of held poses has them, of random columns; the truth is zero.
class RandomModel {
 public:
  RandomModel(unsigned seed, Index nodes, const HoldNoise& noise) : random_(seed), noise_(noise) {
    model_.nodes = nodes;
    model_.earth_weight = {1e8, 1e8, 1e8};
    for (Index k = 0; k < nodes; ++k) {
      for (const FactorKind kind :
           {FactorKind::kAccel, FactorKind::kGyro, FactorKind::kStill, FactorKind::kRestWalk})
        Add(kind, k, 3, 1);
      if (k + 1 == nodes) break;
      Add(FactorKind::kTurn, k, 2, 2);
      Add(FactorKind::kLinkWalk, k, 3, 2);
    }
  }
  const LinearModel& get() const { return model_; }

 private:
  void Add(FactorKind kind, Index node, Index rows, Index nodes) {
    HoldFactor factor;
    factor.kind = kind;
    factor.node = node;
    factor.rows = rows;
    factor.duration_s = 3.0;
    factor.path = 1e-3;
    const double deviation = std::sqrt(VarianceOf(factor, noise_));
    MatrixXd j(rows, nodes * ArrowSystem::kNode + kBase + 1);
    for (double& value : j.reshaped()) value = normal_(random_);
    j.rightCols(1) *= deviation;
    factor.products = j.transpose() * j;
    model_.factors.push_back(factor);
  }

  std::mt19937 random_;
  std::normal_distribution<double> normal_;
  HoldNoise noise_;
  LinearModel model_;
};

HoldNoise TrueNoise() {
  HoldNoise noise;
  noise.angle_random_walk_deg_sqrt_s = noise.usual_angle_random_walk_deg_sqrt_s = 0.006;
  noise.bias_random_walk_deg_s_sqrt_s = 2e-4;
  noise.accel_density_g_sqrt_s = 4e-4;
  noise.pose_scatter_g = 2e-4;
  noise.stillness = 2.0;
  return noise;
}

// How many of the 95 % intervals of the parameters hold, with the noise found from the same rows.
struct Held {
  double over_noise = 0.0, by_the_likeliest = 0.0;
};

Held IntervalsThatHold(Index nodes, unsigned sets) {
  Held held;
  for (unsigned seed = 1; seed <= sets; ++seed) {
    const RandomModel model(seed, nodes, TrueNoise());
    const HoldNoise noise = EstimateNoise(model.get(), TrueNoise());
    const ArrowSystem::Solution fit = SolveModel(model.get(), noise);
    const MatrixXd over = CovarianceOverNoise(model.get(), noise);
    EXPECT_EQ(over.rows(), kBase + 3);
    EXPECT_LT((over - over.transpose()).norm(), 1e-9 * over.norm());
    for (Index i = 0; i < kAtEarth; ++i) {
      held.over_noise += std::fabs(fit.parameters[i]) < 1.96 * std::sqrt(over(i, i));
      held.by_the_likeliest +=
          std::fabs(fit.parameters[i]) < 1.96 * std::sqrt(fit.covariance(i, i));
    }
  }
  held.over_noise /= static_cast<double>(kAtEarth * sets);
  held.by_the_likeliest /= static_cast<double>(kAtEarth * sets);
  return held;
}

// 18 parameters of a set move together as far as its noise does, so that 60 sets tell a share of
// 0.95 to about 0.012: three of these.
TEST(CovarianceOverNoise, HasIntervalsThatHoldWhereFewRowsTellTheNoise) {
  const Held few = IntervalsThatHold(6, 60);
  EXPECT_THAT(few.over_noise, testing::AllOf(testing::Gt(0.914), testing::Lt(0.986)));
  EXPECT_GT(few.over_noise, few.by_the_likeliest);
}

// Where many rows tell the noise there is nothing to average over.
TEST(CovarianceOverNoise, IsThatOfTheLikeliestNoiseWhereManyRowsTellIt) {
  const RandomModel model(3, 200, TrueNoise());
  const HoldNoise noise = EstimateNoise(model.get(), TrueNoise());
  const MatrixXd over = CovarianceOverNoise(model.get(), noise);
  const ArrowSystem::Solution fit = SolveWithMeanOffset(model.get(), noise);
  for (Index i = 0; i < over.rows(); ++i)
    EXPECT_NEAR(over(i, i) / fit.covariance(i, i), 1.0, 0.05) << i;
  EXPECT_EQ(over, CovarianceOverNoise(model.get(), noise)) << "the same points each time";
}

}  // namespace
}  // namespace gyrobench::calibration
