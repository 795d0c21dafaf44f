// What the models of `analyze` do not know must be in their errors, or be told.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <random>
#include <string>
#include <vector>

#include "calibration/estimators/analyzer.h"
#include "tests/calibration/passed_on.h"
#include "tests/calibration/simulated_run.h"

namespace gyrobench::testing {
namespace {

using calibration::AnalysisResult;
using calibration::Analyzer;
using ::testing::Contains;
using ::testing::HasSubstr;
using ::testing::Not;

TurnSchedule LongRests() {
  TurnSchedule schedule;
  schedule.turns = 14;
  schedule.back_and_forth = true;
  schedule.rest_s = 15.0;
  schedule.angle_deg = 90.0;
  return schedule;
}

// The offset of gyro z is drawn anew with each turn, as sensitivity to gravity makes it where the
// turns tilt the sensor.
class AnotherOffsetInEachRest : public PassedOn {
 public:
  AnotherOffsetInEachRest(double scatter_lsb, int seed, MeasurementSink* sink) : PassedOn(*sink) {
    std::mt19937 random(static_cast<unsigned>(seed));
    std::normal_distribution<double> normal(0.0, scatter_lsb);
    const TurnSchedule schedule = LongRests();
    period_s_ = schedule.TurnTime() + schedule.rest_s;
    for (int i = 0; i <= schedule.turns + 1; ++i) offsets_.push_back(normal(random));
  }
  void OnGyro(const GyroSample& sample) override {
    GyroSample other = sample;
    const double turn_s = LongRests().TurnTime();
    other.xi[2] += offsets_.at(static_cast<std::size_t>((sample.t_s + 0.5 * turn_s) / period_s_));
    PassedOn::OnGyro(other);
  }

 private:
  double period_s_ = 0.0;
  std::vector<double> offsets_;
};

// Bounds: chi-square with 29 degrees of freedom, beyond which are 2 of 10000 choices of seeds.
TEST(OffsetScatter, OfRestsIsNoNoiseAndIsInTheErrorsOfTheBias) {
  constexpr int kRuns = 30;
  constexpr double kScatter_lsb = 10.0;
  const SimulatedSensor sensor;
  const double bias_lsb = sensor.bias_deg_s * sensor.nominal_lsb_per_deg_s;
  double at_rest = 0.0, of_all = 0.0;
  for (int seed = 1; seed <= kRuns; ++seed) {
    Analyzer analyzer;
    AnotherOffsetInEachRest other(kScatter_lsb, seed, &analyzer);
    SimulateTurns(LongRests(), sensor, static_cast<std::uint64_t>(seed), &other);
    const AnalysisResult result = analyzer.Result();
    ASSERT_EQ(result.bias.size(), 1u);
    ASSERT_EQ(result.scale.size(), 1u);
    const calibration::BiasResult& bias = result.bias[0];
    const calibration::ScaleResult& scale = result.scale[0];
    EXPECT_THAT(bias.remarks, Contains(HasSubstr("differs from rest to rest")));
    EXPECT_NEAR(bias.noise.angle_random_walk_deg_sqrt_s / sensor.n, 1.0, 0.25);
    EXPECT_NEAR(scale.noise.angle_random_walk_deg_sqrt_s / sensor.n, 1.0, 0.25);
    EXPECT_NEAR(bias.offset_scatter / kScatter_lsb, 1.0, 0.7);
    at_rest += std::pow((bias.coefficients[0] - bias_lsb) / bias.std_errors[0], 2) / kRuns;
    of_all += std::pow((scale.bias - bias_lsb) / scale.bias_std_error, 2) / kRuns;
  }
  for (const double square : {at_rest, of_all}) {
    EXPECT_GT(square, 0.3);
    EXPECT_LT(square, 1.95);
  }
}

TEST(OffsetScatter, IsNotSeenWhereThereIsNone) {
  for (int seed = 1; seed <= 10; ++seed) {
    Analyzer analyzer;
    SimulateTurns(LongRests(), {}, static_cast<std::uint64_t>(seed), &analyzer);
    EXPECT_EQ(analyzer.Result().bias.at(0).offset_scatter, 0.0) << seed;
  }
}

// An error of each stop that readings of 0.001 deg do not show: with it as noise everything fits.
TEST(ReferenceNoise, FarBeyondWhatTheRestsShowIsToldAsALackOfTheModel) {
  SimulatedSensor sensor;
  sensor.stop_half_width_deg = 0.3;
  sensor.stop_accuracy_known = false;
  Analyzer analyzer;
  SimulateTurns(LongRests(), sensor, 1, &analyzer);
  const AnalysisResult worse = analyzer.Result();
  EXPECT_THAT(worse.scale.at(0).remarks, Contains(HasSubstr("taken for noise")));
  EXPECT_GT(worse.scale[0].whitened_rms, 3.0);

  sensor.stop_half_width_deg = 0.001;
  Analyzer exact;
  SimulateTurns(LongRests(), sensor, 1, &exact);
  const AnalysisResult well = exact.Result();
  EXPECT_THAT(well.scale.at(0).remarks, Not(Contains(HasSubstr("taken for noise"))));
  EXPECT_NEAR(well.scale[0].whitened_rms, 1.0, 0.2);
}

}  // namespace
}  // namespace gyrobench::testing
