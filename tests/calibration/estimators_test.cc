// A slice of the campaign in tests/benchmarks/estimators.cc, with odds: each bound below fails by
// chance in fewer than 1 of 10000 choices of seeds (chi-square with 39 degrees of freedom: 0.42
// to 1.85).
#include <gtest/gtest.h>

#include <cmath>

#include "calibration/estimators/analyzer.h"
#include "tests/calibration/simulated_run.h"

namespace gyrobench::testing {
namespace {

using calibration::AnalysisResult;
using calibration::Analyzer;

constexpr int kSeeds = 40;

TEST(ScaleCampaign, FortyTurnsReachTheBoundAndStateItHonestly) {
  const TurnSchedule schedule;
  const SimulatedSensor sensor;
  const double bound = ScaleBound(schedule, sensor);
  double square = 0, claimed = 0, paper = 0;
  int covered = 0;
  for (int seed = 1; seed <= kSeeds; ++seed) {
    Analyzer analyzer;
    SimulateTurns(schedule, sensor, static_cast<std::uint64_t>(seed), &analyzer);
    const AnalysisResult result = analyzer.Result();
    ASSERT_EQ(result.scale.size(), 1u);
    const auto& scale = result.scale[0];
    EXPECT_EQ(scale.axis, SensorAxis::kZ);
    EXPECT_EQ(scale.turns, 40);
    EXPECT_EQ(scale.schedule, "stops");
    for (const auto& bias : result.bias) {
      EXPECT_TRUE(bias.paper_rms_error == 0.0 || bias.paper_rms_error > 1e-9)
          << bias.paper_rms_error << ": rounding is no error of a curve";
    }
    const double error = scale.alpha / sensor.alpha() - 1;
    square += error * error / kSeeds;
    claimed += std::pow(scale.alpha_std_error / sensor.alpha(), 2) / kSeeds;
    paper += std::pow(scale.paper_alpha / sensor.alpha() - 1, 2) / kSeeds;
    covered += std::fabs(error) <= 1.96 * scale.alpha_std_error / sensor.alpha() ? 1 : 0;
  }
  EXPECT_GT(square / (bound * bound), 0.42);
  EXPECT_LT(square / (bound * bound), 1.85 * 1.1);
  EXPECT_NEAR(std::sqrt(claimed) / bound, 1.05, 0.1);
  EXPECT_GE(covered, 33) << "binomial with 95 %";
  EXPECT_GT(paper / square, 1.2) << "the paper's mean weighs all turns alike";
}

TEST(ScaleCampaign, OneTurnUsesTheShaftsAccuracyAndSaysSo) {
  TurnSchedule schedule;
  schedule.turns = 1;
  const SimulatedSensor sensor;
  Analyzer analyzer;
  SimulateTurns(schedule, sensor, 3, &analyzer);
  const AnalysisResult result = analyzer.Result();
  ASSERT_EQ(result.scale.size(), 1u);
  EXPECT_NEAR(result.scale[0].alpha_std_error / sensor.alpha() / ScaleBound(schedule, sensor), 1.0,
              0.1);
  ASSERT_FALSE(result.scale[0].remarks.empty());
  EXPECT_NE(result.scale[0].remarks[0].find("shaft's accuracy"), std::string::npos);
}

TEST(BiasCampaign, AColdStartReachesTheBound) {
  const WarmUp warm_up;
  SimulatedSensor sensor;
  sensor.gyro_rate_hz = 100;
  const double bound = CurveBound(warm_up, sensor);
  double square = 0;
  const int seeds = 12;
  for (int seed = 1; seed <= seeds; ++seed) {
    Analyzer analyzer;
    SimulateWarmUp(warm_up, sensor, static_cast<std::uint64_t>(seed), &analyzer);
    const auto bias = analyzer.Result().bias.at(0);
    EXPECT_GE(bias.coefficients.size(), 4u) << "the cubic term is there to be seen";
    EXPECT_GE(bias.paper_coefficients.size(), 4u);
    const int points = 101;
    for (int i = 0; i < points; ++i) {
      const double t = bias.min_temperature_degC +
                       (bias.max_temperature_degC - bias.min_temperature_degC) * i / (points - 1);
      double sum = 0;
      for (std::size_t j = bias.coefficients.size(); j-- > 0;) {
        sum = sum * (t - bias.reference_temperature_degC) + bias.coefficients[j];
      }
      square += std::pow(sum / sensor.nominal_lsb_per_deg_s - warm_up.Beta(t), 2) / points / seeds;
    }
  }
  // About 4 x 12 degrees of freedom, unequally weighted.
  EXPECT_LT(std::sqrt(square) / bound, 1.6);
  EXPECT_GT(std::sqrt(square) / bound, 0.5);
}

}  // namespace
}  // namespace gyrobench::testing
