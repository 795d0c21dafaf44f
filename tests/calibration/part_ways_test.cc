// A slip of the table, or a reference that dies, does not go into a scale factor without a word.
#include "calibration/estimators/part_ways.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <functional>
#include <random>
#include <utility>

#include "base/error.h"
#include "calibration/estimators/analyzer.h"
#include "calibration/signal/collector.h"
#include "tests/calibration/passed_on.h"
#include "tests/calibration/simulated_run.h"

namespace gyrobench::testing {
namespace {

using calibration::AnalysisResult;
using calibration::Collector;
using calibration::FindPartedWays;
using calibration::PartedWays;
using calibration::Row;
using ::testing::AllOf;
using ::testing::Contains;
using ::testing::ElementsAre;
using ::testing::Field;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

constexpr std::size_t kThirdAxis = 2;
constexpr double kScale = 1.015, kBias_deg_s = 0.4;

// Turns there and back at several speeds between rests; a part whose scale depends on direction and
// speed by what parts do.
std::vector<Row> Turns(int count, std::uint64_t seed) {
  std::mt19937_64 random(seed);
  std::normal_distribution<double> noise(0.0, 0.01);
  std::vector<Row> rows;
  double t_s = 0.0;
  auto add = [&](double length_s, double turn_deg) {
    Row row;
    row.begin_s = t_s;
    row.end_s = t_s += length_s;
    row.still = turn_deg == 0.0;
    row.usable = {true, true, true};
    row.rotation_deg[kThirdAxis] = turn_deg;
    const double rate = turn_deg / length_s;
    const double shape = 1.0 + 5e-4 * (rate > 0.0 ? 1.0 : 0.0) + 1e-5 * std::fabs(rate);
    row.z[kThirdAxis] = kScale * shape * turn_deg + kBias_deg_s * length_s + noise(random);
    rows.push_back(row);
  };
  for (int k = 0; k < count; ++k) {
    for (int piece = 0; piece < 3; ++piece) add(1.0, 0.0);
    add(180.0 / (10.0 + 10.0 * (k % 4)), k % 2 == 0 ? 180.0 : -180.0);
  }
  add(1.0, 0.0);
  return rows;
}

TEST(GyroAndReference, DoNotPartWaysOnASoundBench) {
  for (std::uint64_t seed = 1; seed <= 200; ++seed) {
    const PartedWays parted = FindPartedWays(Turns(12, seed), kThirdAxis, kScale);
    EXPECT_THAT(parted.rows, IsEmpty()) << "seed " << seed;
    EXPECT_THAT(parted.defects, IsEmpty()) << "seed " << seed;
  }
}

// A part that is taken from -40 to 85 degC while it is measured: most of the rests are at the end.
TEST(GyroAndReference, DoNotPartWaysWhereTheOffsetFollowsTheTemperature) {
  constexpr double kChange_deg_s = 18.0;
  std::vector<Row> rows = Turns(24, 11);
  const double end_s = rows.back().end_s;
  for (Row& row : rows) {
    const double offset_deg_s = kChange_deg_s * std::exp(-6.0 * row.begin_s / end_s);
    row.z[kThirdAxis] += offset_deg_s * row.duration_s();
  }
  for (const std::size_t i : FindPartedWays(rows, kThirdAxis, kScale).rows)
    EXPECT_FALSE(rows[i].still) << rows[i].begin_s;
}

// What the offset at rest is known to makes more of a turn that takes longer.
TEST(GyroAndReference, DoNotPartWaysInTheSlowestTurns) {
  constexpr double kWalk_deg_sqrt_s = 0.01, kSlow_s = 90.0;
  for (std::uint64_t seed = 1; seed <= 50; ++seed) {
    std::mt19937_64 random(seed);
    std::normal_distribution<double> normal;
    std::vector<Row> rows;
    double t_s = 0.0;
    auto add = [&](double length_s, double turn_deg) {
      Row row;
      row.begin_s = t_s;
      row.end_s = t_s += length_s;
      row.still = turn_deg == 0.0;
      row.usable = {true, true, true};
      row.rotation_deg[kThirdAxis] = turn_deg;
      row.z[kThirdAxis] =
          kScale * turn_deg + kWalk_deg_sqrt_s * std::sqrt(length_s) * normal(random);
      rows.push_back(row);
    };
    for (int turn = 0; turn < 20; ++turn) {
      add(1.0, 0.0);
      add(turn % 9 == 8 ? kSlow_s : 1.5, turn % 2 == 0 ? 90.0 : -90.0);
    }
    add(1.0, 0.0);
    EXPECT_THAT(FindPartedWays(rows, kThirdAxis, kScale).rows, IsEmpty()) << "seed " << seed;
  }
}

// One turn among those about an upright axis is about a level one: gravity at rest is not that of
// the turn, and an offset that goes with it is no slip.
TEST(GyroAndReference, DoNotPartWaysByGSensitivity) {
  constexpr double kSensitivity_deg_s_g = 0.08;
  std::vector<Row> rows = Turns(12, 5);
  std::vector<Vector3> gravity_g_s;
  int turns = 0;
  for (Row& row : rows) {
    gravity_g_s.push_back({row.duration_s(), 0.0, 0.0});
    if (row.still || ++turns != 5) continue;
    gravity_g_s.back() = {0.0, -row.duration_s(), 0.0};
    row.z[kThirdAxis] -= 2.0 * kScale * kSensitivity_deg_s_g * row.duration_s();
  }
  EXPECT_THAT(FindPartedWays(rows, kThirdAxis, kScale, gravity_g_s).defects, IsEmpty());
  EXPECT_FALSE(FindPartedWays(rows, kThirdAxis, kScale).defects.empty())
      << "there is something to allow";
  std::ranges::find(rows, false, &Row::still)->z[kThirdAxis] += 5.0;
  EXPECT_FALSE(FindPartedWays(rows, kThirdAxis, kScale, gravity_g_s).defects.empty())
      << "a slip is one";
}

TEST(GyroAndReference, ThatAreNothingOfEachOtherAreNotCompared) {
  std::vector<Row> rows = Turns(12, 13);
  for (Row& row : rows) row.z[kThirdAxis] = 0.0;
  EXPECT_THAT(FindPartedWays(rows, kThirdAxis, kScale).rows, IsEmpty());
}

TEST(GyroAndReference, PartWaysWhereTheTableSlips) {
  for (const double slip_deg : {5.0, -5.0, 1.0}) {
    std::vector<Row> rows = Turns(12, 3);
    constexpr std::size_t kSlipped = 4 * 5 + 3;
    ASSERT_FALSE(rows[kSlipped].still);
    rows[kSlipped].z[kThirdAxis] += slip_deg;
    const PartedWays parted = FindPartedWays(rows, kThirdAxis, kScale);
    EXPECT_THAT(parted.rows, ElementsAre(kSlipped));
    ASSERT_EQ(parted.defects.size(), 1u);
    EXPECT_EQ(parted.defects[0].kind, "turn_disagrees");
    EXPECT_EQ(parted.defects[0].first_t_s, rows[kSlipped].begin_s);
    EXPECT_FALSE(parted.too_many);
  }
}

// A slip that takes nearly all of a turn away from the reference.
TEST(GyroAndReference, PartWaysInATurnOfWhichTheReferenceSawLittle) {
  std::vector<Row> rows = Turns(12, 5);
  constexpr std::size_t kSlipped = 4 * 5 + 3;
  rows[kSlipped].rotation_deg[kThirdAxis] *= 0.01;
  EXPECT_THAT(FindPartedWays(rows, kThirdAxis, kScale).rows, ElementsAre(kSlipped));
}

TEST(GyroAndReference, ThatPartWaysInManyTurnsLeaveNothingOut) {
  std::vector<Row> rows = Turns(12, 3);
  for (std::size_t k = 0; k < 5; ++k) rows[4 * k + 3].z[kThirdAxis] += 5.0 + static_cast<double>(k);
  const PartedWays parted = FindPartedWays(rows, kThirdAxis, kScale);
  EXPECT_TRUE(parted.too_many);
  EXPECT_THAT(parted.rows, IsEmpty());
  ASSERT_EQ(parted.defects.size(), 1u);
  EXPECT_EQ(parted.defects[0].count, 5);
}

// Several turns and the rests between them pass for one rest then, and their pieces are more than
// those of the true rests: of one speed they are not.
TEST(GyroAndReference, PartWaysWhereTheReferenceStandsForLong) {
  std::vector<Row> rows;
  for (const Row& row : Turns(12, 7)) {
    if (row.still || row.duration_s() > 15.0) {
      rows.push_back(row);
      continue;
    }
    const double pieces = std::floor(row.duration_s());
    for (double k = 0.0; k < pieces; k += 1.0) {
      Row piece = row;
      piece.still = true;
      piece.begin_s = row.begin_s + k * row.duration_s() / pieces;
      piece.end_s = piece.begin_s + row.duration_s() / pieces;
      piece.z[kThirdAxis] /= pieces;
      piece.rotation_deg[kThirdAxis] = 0.0;
      rows.push_back(piece);
    }
  }
  const auto stood = [](const Row& row) { return row.still && std::fabs(row.z[kThirdAxis]) > 5.0; };
  const auto rests = std::ranges::count_if(rows, [](const Row& row) { return row.still; });
  const auto wrong = std::ranges::count_if(rows, stood);
  ASSERT_GT(2 * wrong, rests);
  const PartedWays parted = FindPartedWays(rows, kThirdAxis, kScale);
  EXPECT_EQ(std::ssize(parted.rows), wrong);
  for (const std::size_t i : parted.rows) EXPECT_TRUE(stood(rows[i])) << i;
}

// What a run says, with the readings of the reference changed on their way.
class ShownOtherwise final : public PassedOn {
 public:
  ShownOtherwise(MeasurementSink& sink,
                 std::function<double(double t_s, double angle_deg)> shown_deg)
      : PassedOn(sink), shown_deg_(std::move(shown_deg)) {}
  void OnAngle(const AngleSample& sample) override {
    AngleSample changed = sample;
    changed.angle_deg = shown_deg_(sample.t_s, sample.angle_deg);
    PassedOn::OnAngle(changed);
  }

 private:
  std::function<double(double, double)> shown_deg_;
};

constexpr double kTurn_deg = 90.0;

AnalysisResult AnalyzeWith(std::function<double(double, double)> shown_deg) {
  TurnSchedule schedule;
  schedule.angle_deg = kTurn_deg;
  schedule.turns = 12;
  schedule.back_and_forth = true;
  schedule.rest_s = 5.0;
  Collector collector;
  ShownOtherwise shown(collector, std::move(shown_deg));
  SimulateTurns(schedule, SimulatedSensor(), 1, &shown);
  return calibration::Analyze(collector.Take());
}

AnalysisResult Sound() {
  return AnalyzeWith([](double, double angle_deg) { return angle_deg; });
}

TEST(AnalysisOfATableThatSlips, SaysSoAndGivesTheScaleOfTheOtherTurns) {
  // In the middle of a turn the reference loses 5 deg for good.
  const double slip_s = 0.5 * Sound().duration_s + 3.0;
  const AnalysisResult result = AnalyzeWith(
      [=](double t_s, double angle_deg) { return angle_deg - (t_s > slip_s ? 5.0 : 0.0); });
  EXPECT_THAT(result.defects, Contains(Field(&Defect::kind, "turn_disagrees")));
  ASSERT_EQ(result.scale.size(), 1u);
  EXPECT_THAT(result.scale[0].remarks, Contains(AllOf(HasSubstr("slip"), HasSubstr("left out"))));
  const double expected = Sound().scale.at(0).alpha;
  EXPECT_NEAR(result.scale[0].alpha / expected, 1.0,
              4.0 * result.scale[0].alpha_std_error / expected);
}

TEST(AnalysisWithAReferenceThatDies, SaysSoAndUsesWhatWasBefore) {
  const double dies_s = 0.6 * Sound().duration_s;
  double last_deg = 0.0;
  const AnalysisResult result = AnalyzeWith([&](double t_s, double angle_deg) {
    if (t_s < dies_s) last_deg = angle_deg;
    return last_deg;
  });
  EXPECT_THAT(result.defects, Contains(Field(&Defect::kind, "turned_at_rest")));
  ASSERT_EQ(result.scale.size(), 1u);
  const double expected = Sound().scale.at(0).alpha;
  EXPECT_NEAR(result.scale[0].alpha / expected, 1.0, 0.002);
}

TEST(AnalysisOfSamplesFarApart, AsksForMilliseconds) {
  Collector collector;
  MeasurementInfo info;
  info.gyro_present[kThirdAxis] = true;
  collector.OnInfo(info);
  for (int k = 0; k < 200; ++k) {
    GyroSample sample;
    sample.t_s = 5.0 * k;
    sample.xi[kThirdAxis] = 0.01 * (k % 3);
    collector.OnGyro(sample);
  }
  try {
    calibration::Analyze(collector.Take());
    FAIL() << "samples 5 s apart were analysed";
  } catch (const DataError& error) {
    EXPECT_THAT(error.what(), AllOf(HasSubstr("5 s"), HasSubstr("milliseconds")));
  }
}

TEST(AnalysisOfASoundRun, SaysNothingOfIt) { EXPECT_THAT(Sound().defects, IsEmpty()); }

}  // namespace
}  // namespace gyrobench::testing
