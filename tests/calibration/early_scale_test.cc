// What a run says of a scale factor while it is young: of a turn that is not over, and of an axis
// that was moved along with another.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <optional>

#include "calibration/estimators/analyzer.h"
#include "tests/calibration/simulated_run.h"
#include "tests/calibration/synthetic_bench.h"

namespace gyrobench::testing {
namespace {

using calibration::AnalysisResult;
using calibration::Analyzer;
using calibration::ScaleResult;
using ::testing::Contains;
using ::testing::HasSubstr;

std::optional<ScaleResult> ScaleOfZ(const AnalysisResult& result) {
  for (const ScaleResult& scale : result.scale) {
    if (scale.axis == SensorAxis::kZ) return scale;
  }
  return std::nullopt;
}

// Passes on what there is until a time.
class Until : public MeasurementSink {
 public:
  Until(double end_s, MeasurementSink* sink) : end_s_(end_s), sink_(sink) {}
  void OnInfo(const MeasurementInfo& info) override { sink_->OnInfo(info); }
  void OnGyro(const GyroSample& sample) override {
    if (sample.t_s < end_s_) sink_->OnGyro(sample);
  }
  void OnAngle(const AngleSample& sample) override {
    if (sample.t_s < end_s_) sink_->OnAngle(sample);
  }
  void OnOrientation(const OrientationSample& /*sample*/) override {}
  void OnTickPair(const TickPair& /*pair*/) override {}
  void OnSegment(const SegmentMark& /*mark*/) override {}
  void OnDefect(const Defect& /*defect*/) override {}

 private:
  double end_s_;
  MeasurementSink* sink_;
};

// The table stands again, for less than what makes a rest: as when a daemon asks after a turn.
// Chi-square with 39 degrees of freedom: beyond these bounds for fewer than 1 of 10000 choices of
// seeds.
TEST(EarlyScale, OfATurnThatHasNotComeToItsRestStatesItsErrorHonestly) {
  constexpr int kSeeds = 40;
  TurnSchedule schedule;
  schedule.turns = 1;
  schedule.angle_deg = 90.0;
  schedule.acceleration_deg_s2 = 80.0;
  SimulatedSensor sensor;
  sensor.n = 1e-4;
  sensor.latency_s = 0.5 / sensor.gyro_rate_hz;  // that of the gyro, which averages
  double square = 0.0;
  for (int seed = 1; seed <= kSeeds; ++seed) {
    Analyzer analyzer;
    Until until(schedule.rest_s + schedule.TurnTime() + 0.3, &analyzer);
    SimulateTurns(schedule, sensor, static_cast<std::uint64_t>(seed), &until);
    const std::optional<ScaleResult> scale = ScaleOfZ(analyzer.Result());
    ASSERT_TRUE(scale) << "seed " << seed;
    ASSERT_EQ(scale->turns, 0);
    square += std::pow((scale->alpha - sensor.alpha()) / scale->alpha_std_error, 2) / kSeeds;
  }
  EXPECT_GT(square, 0.42);
  EXPECT_LT(square, 1.85);
}

// The middle axis tips z, so that the outer one turns y along with it.
AnalysisResult TippedTurn(double tipped_deg, const BenchSensor& sensor) {
  Motion motion;
  motion.Rest(20.0).Turn(kMiddleAxis, tipped_deg, 20.0).Turn(kOuterAxis, 90.0, 30.0).Rest(5.0);
  const SyntheticBench bench(motion, sensor);
  return calibration::Analyze(bench.Measure({}, 3));
}

BenchSensor CrossAxisSensor() {
  BenchSensor sensor;
  sensor.m_row = {0.0, -0.01, 1.015};
  sensor.three_channels = true;
  return sensor;
}

TEST(EarlyScale, OfAnAxisThatTurnedMainlyAlongWithAnotherIsNotGiven) {
  const AnalysisResult result = TippedTurn(80.0, CrossAxisSensor());
  EXPECT_FALSE(ScaleOfZ(result));
  EXPECT_THAT(result.remarks, Contains(HasSubstr("scale of z: not estimated, its axis turned only "
                                                 "with the others")));
}

TEST(EarlyScale, OfAnAxisThatTurnedSomewhatAlongWithAnotherCountsCrossAxisSensitivity) {
  for (const double tipped_deg : {20.0, 45.0}) {
    const std::optional<ScaleResult> scale = ScaleOfZ(TippedTurn(tipped_deg, CrossAxisSensor()));
    ASSERT_TRUE(scale) << tipped_deg;
    const double off = scale->alpha * 1.015 - 1.0, error = scale->alpha_std_error * 1.015;
    EXPECT_GT(std::fabs(off), 0.002) << "there is something to be honest about";
    EXPECT_LT(std::fabs(off), 2.0 * error);
    EXPECT_LT(error, 0.02);
  }
}

// As soon as another turn tells the axes apart, nothing has to be allowed for.
TEST(EarlyScale, OfAxesThatCanBeToldApartIsPrecise) {
  Motion motion;
  motion.Rest(20.0).Turn(kMiddleAxis, 80.0, 20.0).Turn(kOuterAxis, 90.0, 30.0);
  for (int i = 0; i < 4; ++i) motion.ThereAndBack(kInnerAxis, 90.0, 30.0);
  const SyntheticBench bench(motion, CrossAxisSensor());
  const std::optional<ScaleResult> scale = ScaleOfZ(calibration::Analyze(bench.Measure({}, 3)));
  ASSERT_TRUE(scale);
  EXPECT_LT(scale->alpha_std_error * 1.015, 0.001);
  EXPECT_LT(std::fabs(scale->alpha * 1.015 - 1.0), 3.0 * scale->alpha_std_error * 1.015);
}

}  // namespace
}  // namespace gyrobench::testing
