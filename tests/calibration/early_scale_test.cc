// What a run says of a scale factor while it is young: of a turn that is not over, and of an axis
// that was moved along with another.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <optional>
#include <random>

#include "calibration/estimators/analyzer.h"
#include "calibration/estimators/scale_problem.h"
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
// Chi-square with 40 degrees of freedom: beyond these bounds for 13 of 10000 choices of seeds.
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

// There and back and there: an end is the end of one way and the begin of the next. The slope of
// the drawn errors at the ends over the rotations scatters as is foreseen (10 % is over 5 of its
// own standard deviations).
TEST(EarlyScale, ErrorsAtTheEndsOfWaysThereAndBackCountForBothWays) {
  constexpr int kDraws = 6000;
  constexpr std::array<double, 4> kEnds_deg = {0.0, 90.0, 20.0, 80.0};
  calibration::Columns columns;
  for (std::size_t k = 0; k + 1 < kEnds_deg.size(); ++k) {
    for (int i = 0; i <= 20; ++i) {
      calibration::Node node;
      node.rotation_deg[2] = std::lerp(kEnds_deg[k], kEnds_deg[k + 1], i / 20.0);
      columns.nodes.push_back(node);
    }
  }
  const calibration::OneWayRotations ways = calibration::CountOneWayRotations(columns, 2);
  ASSERT_EQ(ways.count, 3);
  std::mt19937 random(31);
  std::normal_distribution<double> normal;
  double square = 0.0;
  for (int draw = 0; draw < kDraws; ++draw) {
    double product = 0.0, rotations = 0.0, before = normal(random);
    for (std::size_t k = 1; k < kEnds_deg.size(); ++k) {
      const double way = kEnds_deg[k] - kEnds_deg[k - 1], after = normal(random);
      product += way * (after - before);
      rotations += way * way;
      before = after;
    }
    square += std::pow(product / rotations, 2) / kDraws;
  }
  EXPECT_NEAR(ways.ends_square_deg2 / std::pow(ways.square_deg2, 2) / square, 1.0, 0.1);
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

// Turns about z, which lies level, of a sensor whose offset goes with gravity.
std::optional<ScaleResult> ScaleOfLevelTurns(int turns, bool back) {
  Motion motion;
  motion.Rest(20.0).Turn(kMiddleAxis, 90.0, 20.0).Rest(10.0);
  for (int i = 0; i < turns; ++i)
    motion.Turn(kInnerAxis, back && i % 2 == 1 ? -360.0 : 360.0, 30.0).Rest(5.0);
  const SyntheticBench bench(motion);
  Injection sensitivity;
  sensitivity.rate_deg_s = [](const BenchState& s) { return 0.08 * s.g[1] - 0.03 * s.g[0]; };
  return ScaleOfZ(calibration::Analyze(bench.Measure(sensitivity, 5)));
}

TEST(EarlyScale, OfTurnsOneWayAboutALevelAxisCountsGSensitivity) {
  for (const int turns : {1, 3}) {
    const std::optional<ScaleResult> scale = ScaleOfLevelTurns(turns, false);
    ASSERT_TRUE(scale) << turns;
    const double off = scale->alpha * 1.015 - 1.0, error = scale->alpha_std_error * 1.015;
    EXPECT_GT(std::fabs(off), 0.001) << "there is something to be honest about";
    EXPECT_LT(std::fabs(off), 2.5 * error);
    EXPECT_LT(error, 0.01);
    EXPECT_THAT(scale->remarks, Contains(HasSubstr("g-sensitivity is contained")));
  }
}

// What the offset at rest adds to the turn there it takes off the turn back.
TEST(EarlyScale, OfTurnsThereAndBackAboutALevelAxisIsPrecise) {
  const std::optional<ScaleResult> scale = ScaleOfLevelTurns(4, true);
  ASSERT_TRUE(scale);
  const double off = scale->alpha * 1.015 - 1.0, error = scale->alpha_std_error * 1.015;
  EXPECT_LT(error, 3e-4);
  EXPECT_LT(std::fabs(off), 4.0 * error);
}

}  // namespace
}  // namespace gyrobench::testing
