#include "calibration/estimators/analyzer.h"

#include <gtest/gtest.h>

#include <cmath>
#include <nlohmann/json.hpp>

#include "calibration/estimators/result_json.h"
#include "tests/calibration/passed_on.h"
#include "tests/calibration/simulated_run.h"

namespace gyrobench::testing {
namespace {

using calibration::AnalysisResult;
using calibration::Analyzer;
using calibration::ScaleResult;
using calibration::ToJson;

ScaleResult ScaleOf(const TurnSchedule& schedule, const SimulatedSensor& sensor,
                    std::uint64_t seed = 1) {
  Analyzer analyzer;
  SimulateTurns(schedule, sensor, seed, &analyzer);
  const AnalysisResult result = analyzer.Result();
  EXPECT_EQ(result.scale.size(), 1u);
  return result.scale.at(0);
}

// A daemon asks after every segment, `analyze` once at the end.
TEST(Analyzer, GivesTheSameNumbersToTheLastDigitHoweverOftenItIsAsked) {
  TurnSchedule schedule;
  schedule.turns = 12;
  Analyzer once, often;
  SimulateTurns(schedule, {}, 5, &once);
  int asked = 0;
  SimulateTurns(schedule, {}, 5, &often, [&] {
    ++asked;
    EXPECT_NO_THROW(often.Result());
  });
  EXPECT_GE(asked, 24);
  EXPECT_EQ(ToJson(once.Result()).dump(), ToJson(often.Result()).dump());
}

TEST(Analyzer, HasAResultAfterTheFirstTurnAndABetterOneAfterMore) {
  Analyzer analyzer;
  std::vector<double> errors;
  SimulateTurns({}, {}, 5, &analyzer, [&] {
    const AnalysisResult result = analyzer.Result();
    if (!result.scale.empty())
      errors.push_back(result.scale[0].alpha_std_error / result.scale[0].alpha);
  });
  ASSERT_GT(errors.size(), 60u);
  EXPECT_LT(errors.front(), 0.01);
  EXPECT_LT(errors.back(), 1e-4);
}

// Rest to rest, the latency of the reference's bus falls out.
TEST(Analyzer, ScaleDoesNotDependOnTheReferencesLatency) {
  SimulatedSensor late;
  late.latency_s = 0.02;
  const ScaleResult a = ScaleOf({}, {}), b = ScaleOf({}, late);
  EXPECT_NEAR(b.alpha / a.alpha, 1.0, 0.3 * a.alpha_std_error / a.alpha);
}

TEST(Analyzer, TurnsOneWayAreWorthTenTimesTurnsBackAndForth) {
  TurnSchedule back;
  back.back_and_forth = true;
  const double ratio = ScaleOf(back, {}).alpha_std_error / ScaleOf({}, {}).alpha_std_error;
  EXPECT_GT(ratio, 7);
  EXPECT_LT(ratio, 13);
}

TEST(Analyzer, FindsScaleBiasAndNoiseOfTheSensor) {
  const SimulatedSensor sensor;
  TurnSchedule schedule;
  const ScaleResult scale = ScaleOf(schedule, sensor, 2);
  EXPECT_NEAR(scale.alpha, sensor.alpha(), 4 * scale.alpha_std_error);
  EXPECT_NEAR(scale.scale_error, 1 / 1.015 - 1, 4 * scale.alpha_std_error / scale.alpha);
  EXPECT_NEAR(scale.bias, 0.2 * 131, 0.0015 * 131) << "the walk's mean over 100 s is 6e-4 deg/s";
  EXPECT_LT(scale.bias_std_error, 0.001 * 131);
  EXPECT_NEAR(scale.noise.angle_random_walk_deg_sqrt_s, 0.0035, 0.0015);
  EXPECT_NEAR(scale.noise.reference_deg, 0.0144, 0.006);
  EXPECT_NEAR(scale.max_rate_deg_s, 9 / schedule.TurnTime(), 2.5);
  EXPECT_NEAR(scale.whitened_rms, 1.0, 0.2);
}

TEST(Analyzer, AddsTheTimeBasesErrorToTheScales) {
  Analyzer analyzer;
  SimulateTurns({}, {}, 1, &analyzer);
  const double before = analyzer.Result().scale.at(0).alpha_std_error;
  for (int i = 0; i < 50; ++i)
    analyzer.OnTickPair({2.0 * i, 2.0 * i * 1.002 + (i % 2 == 0 ? 0.02 : -0.02)});
  const ScaleResult scale = analyzer.Result().scale.at(0);
  EXPECT_NEAR(scale.tick_ratio, 1.002, 5 * scale.tick_ratio_std_error);
  EXPECT_NEAR(scale.alpha_std_error, std::hypot(before, scale.alpha * scale.tick_ratio_std_error),
              1e-12 * scale.alpha);
  EXPECT_GT(scale.alpha_std_error, before);
}

// Earth's rotation at the pole, table level: 0.00418 deg/s about z at rest and in motion.
TEST(Analyzer, TakesEarthsRotationForWhatItIs) {
  class WithLatitude final : public PassedOn {
   public:
    using PassedOn::PassedOn;
    void OnInfo(const MeasurementInfo& info) override {
      MeasurementInfo mine = info;
      mine.site_latitude_deg = 90.0;
      PassedOn::OnInfo(mine);
    }
  };
  Analyzer without, with;
  WithLatitude door(with);
  SimulateTurns({}, {}, 1, &without);
  SimulateTurns({}, {}, 1, &door);
  const AnalysisResult a = without.Result(), b = with.Result();
  const double units = 1 / a.scale.at(0).alpha, earth = 15.041 / 3600;
  EXPECT_NEAR(a.scale[0].bias - b.scale.at(0).bias, earth * units, 1e-3 * earth * units);
  EXPECT_NEAR(a.bias.at(0).coefficients[0] - b.bias.at(0).coefficients[0], earth * units,
              1e-3 * earth * units);
}

TEST(Analyzer, KeepsOnlyRestsForTheBiasOfARunWithTurns) {
  Analyzer analyzer;
  SimulateTurns({}, {}, 1, &analyzer);
  const AnalysisResult result = analyzer.Result();
  ASSERT_EQ(result.bias.size(), 1u);
  EXPECT_NEAR(result.bias[0].duration_s, 82.0, 3.0);
  EXPECT_NEAR(result.bias[0].coefficients.at(0), result.scale.at(0).bias,
              5 * result.bias[0].std_errors.at(0));
  EXPECT_EQ(result.bias[0].coefficients.size(), 1u);
}

TEST(Analyzer, MoreNoiseOrFewerTurnsMeanALargerStatedError) {
  SimulatedSensor noisy;
  noisy.n *= 2;
  noisy.stop_half_width_deg *= 2;
  TurnSchedule few;
  few.turns = 10;
  const double base = ScaleOf({}, {}).alpha_std_error;
  EXPECT_NEAR(ScaleOf({}, noisy).alpha_std_error / base, 2.0, 0.6);
  EXPECT_GT(ScaleOf(few, {}).alpha_std_error / base, 3.0);
}

}  // namespace
}  // namespace gyrobench::testing
