// An angle that begins again after a turn and is read seldom gives the columns of one that runs on,
// where the gyro tells the turns.
#include "calibration/signal/turns_by_gyro.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "calibration/signal/collector.h"

namespace gyrobench::calibration {
namespace {

// Rests of 5 s, then 15 s at each of these rates in turn; the outer axis of a stand whose middle
// axis stands at 90 deg, so that the sensor's y feels it, or the sensor's own z.
struct Scene {
  ReferenceKind reference = ReferenceKind::kSensorAngle;
  double fastest_deg_s = 60.0;
  double reference_hz = 2.0;
  bool sensitivity_given = true;
  bool follows = true;    // the gyro
  double wrap_deg = 0.0;  // 0: the angle runs on
};

double RateAt(const Scene& scene, double t_s) {
  const double part[] = {0.3, 0.6, 1.0};
  const auto turn = static_cast<std::size_t>(t_s / 20.0);
  return t_s - 20.0 * static_cast<double>(turn) < 5.0 ? 0.0 : part[turn % 3] * scene.fastest_deg_s;
}

Recording Measure(const Scene& scene) {
  constexpr double kStep_s = 0.01;
  const bool stand = scene.reference == ReferenceKind::kStandAngles;
  MeasurementInfo info;
  info.gyro_present = {true, true, true};
  if (scene.sensitivity_given) info.gyro_units_per_deg_s = 131.0;
  info.reference = scene.reference;
  info.reference_axis = SensorAxis::kZ;
  info.stand_axis_present = {true, true, true};
  Collector collector;
  collector.OnInfo(info);
  std::mt19937_64 random(3);
  std::normal_distribution<double> noise(0.0, 3.0);
  const std::size_t feels = stand ? 1 : 2;
  double angle_deg = 0.0;
  for (int i = 0; i < 24000; ++i) {
    const double t_s = kStep_s * i, rate = RateAt(scene, t_s);
    if (i > 0) angle_deg += 0.5 * (rate + RateAt(scene, t_s - kStep_s)) * kStep_s;
    GyroSample sample{t_s, {40.0 + noise(random), noise(random), noise(random)}};
    sample.xi[feels] += (scene.follows ? 131.0 * 1.02 * rate : 0.0) - 60.0;
    collector.OnGyro(sample);
    if (i % static_cast<int>(std::lround(1.0 / (scene.reference_hz * kStep_s))) != 0) continue;
    const double turns =
        scene.wrap_deg > 0.0 ? std::floor((angle_deg + 360.0 - scene.wrap_deg) / 360.0) : 0.0;
    const double read_deg = angle_deg - 360.0 * turns;
    if (!stand) {
      collector.OnAngle({t_s, 2, read_deg});
      continue;
    }
    collector.OnAngle({t_s, 0, read_deg});
    collector.OnAngle({t_s, 1, 90.0});
    collector.OnAngle({t_s, 2, 0.0});
  }
  return collector.Take();
}

std::int64_t CountOf(const Recording& recording, const std::string& kind) {
  std::int64_t count = 0;
  for (const Defect& defect : recording.defects) count += defect.kind == kind ? defect.count : 0;
  return count;
}

void ExpectSame(const Vector3& a, const Vector3& b) {
  for (std::size_t c = 0; c < 3; ++c) {
    const bool neither = std::isnan(a[c]) && std::isnan(b[c]);
    EXPECT_NEAR(neither ? 0.0 : a[c], neither ? 0.0 : b[c], 1e-6);
  }
}

// Through the wrap at 180 as at 360 deg.
TEST(TurnsByGyro, GiveTheColumnsOfAnAngleThatRunsOn) {
  for (const ReferenceKind reference : {ReferenceKind::kSensorAngle, ReferenceKind::kStandAngles}) {
    for (const double wrap_deg : {180.0, 360.0}) {
      for (const bool given : {true, false}) {
        Scene scene{.reference = reference, .sensitivity_given = given};
        const Recording expected = Measure(scene);
        EXPECT_EQ(CountOf(expected, "reference_wrapped"), 0);
        scene.wrap_deg = wrap_deg;
        const Recording found = Measure(scene);
        EXPECT_GT(CountOf(found, "reference_wrapped"), 10);
        EXPECT_EQ(CountOf(found, kTurnsUnknown), 0);
        ASSERT_EQ(found.columns.nodes.size(), expected.columns.nodes.size());
        for (std::size_t i = 0; i < found.columns.nodes.size(); ++i) {
          const Node &a = found.columns.nodes[i], &b = expected.columns.nodes[i];
          ExpectSame(a.rotation_deg, b.rotation_deg);
          ExpectSame(a.table_deg, b.table_deg);
          ExpectSame(a.mean.rotation_deg, b.mean.rotation_deg);
        }
        ASSERT_EQ(found.columns.rests.size(), expected.columns.rests.size());
        ASSERT_GT(expected.columns.rests.size(), 5U);
        for (std::size_t i = 0; i < found.columns.rests.size(); ++i)
          ExpectSame(found.columns.rests[i].rotation_deg, expected.columns.rests[i].rotation_deg);
      }
    }
  }
}

// By up to 500 deg from one reading to the next: only a sensitivity that is declared tells the
// turns.
TEST(TurnsByGyro, AreUnknownWhereNeitherTheReadingsNorTheTableSayTheSensitivity) {
  Scene scene{.fastest_deg_s = 500.0, .reference_hz = 1.0, .wrap_deg = 360.0};
  const Recording told = Measure(scene);
  EXPECT_EQ(CountOf(told, kTurnsUnknown), 0);
  EXPECT_GT(CountOf(told, "reference_wrapped"), 50);
  scene.sensitivity_given = false;
  const Recording found = Measure(scene);
  EXPECT_GT(CountOf(found, kTurnsUnknown), 10);
  EXPECT_EQ(CountOf(found, "reference_wrapped"), 0);
}

// A reference that goes on while the gyro stands still is one thing, its wrap another.
TEST(TurnsByGyro, AreToldByAGyroThatIsNotOnTheTableAsWell) {
  const Recording found = Measure({.follows = false, .wrap_deg = 360.0});
  EXPECT_GT(CountOf(found, "reference_wrapped"), 10);
  EXPECT_NEAR(found.columns.nodes.back().rotation_deg[2],
              Measure({.follows = false}).columns.nodes.back().rotation_deg[2], 1e-6);
}

// A table that turns by more than half a turn between two readings, within its one turn.
TEST(TurnsByGyro, LeaveAnAngleAloneThatJumpsAsTheGyroTurns) {
  constexpr double kStep_s = 0.01;
  MeasurementInfo info;
  info.gyro_unit = RateUnit::kDegPerSecond;
  info.gyro_units_per_deg_s = 1.0;
  info.gyro_present = {false, false, true};
  info.reference = ReferenceKind::kSensorAngle;
  Collector collector;
  collector.OnInfo(info);
  double angle_deg = 0.0, before = 0.0;
  for (int i = 0; i < 20000; ++i) {
    const double t_s = kStep_s * i, in_s = std::fmod(t_s, 10.0);
    const double rate = in_s < 6.0 || in_s >= 7.0     ? 0.0
                        : std::fmod(t_s, 20.0) < 10.0 ? 200.0
                                                      : -200.0;
    angle_deg += 0.5 * (rate + before) * kStep_s;
    before = rate;
    collector.OnGyro({t_s, {kMissing, kMissing, rate + 0.3 + 0.02 * std::sin(i)}});
    if (i % 100 == 0) collector.OnAngle({t_s, 2, angle_deg});
  }
  const Recording found = collector.Take();
  EXPECT_EQ(CountOf(found, kTurnsUnknown), 0);
  EXPECT_EQ(CountOf(found, "reference_wrapped"), 0);
  EXPECT_NEAR(found.columns.nodes.back().rotation_deg[2], 0.0, 1.0);
}

}  // namespace
}  // namespace gyrobench::calibration
