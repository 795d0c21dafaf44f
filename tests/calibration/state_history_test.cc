// The state along a measurement where columns are missing for a time.
#include "calibration/state/state_history.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "calibration/trace/shared_columns.h"
#include "tests/calibration/synthetic_bench.h"
#include "tests/calibration/trace_story.h"

namespace gyrobench::testing {
namespace {

using calibration::MakeStateHistory;
using calibration::Recording;
using calibration::RoughSensitivity;
using calibration::SensorState;
using calibration::SharedColumns;
using calibration::StateHistory;
using ::testing::HasSubstr;

constexpr double kSlope_degC_s = 0.05;

struct Told {
  Recording recording;
  StateHistory history;
};

Told Tell(const Story& story) {
  Told out{story.Collect(), {}};
  out.history = MakeStateHistory(out.recording, RoughSensitivity(out.recording), true,
                                 out.recording.info.covariates);
  out.history.recording = nullptr;
  return out;
}

// Warms up steadily to 120 s, stays from then on; not known in (begin, end).
Story WithoutTemperature(double begin_s, double end_s) {
  Story story;
  story.duration_s = 240.0;
  story.temperature_degC = [=](double t_s) {
    const double value = 20.0 + kSlope_degC_s * std::min(t_s, 120.0);
    return t_s > begin_s && t_s < end_s ? kMissing : value;
  };
  return story;
}

bool Within(const SensorState& point, double begin_s, double end_s) {
  return point.t_s > begin_s && point.t_s < end_s;
}

TEST(TrailWithAShortGapOfTemperature, GoesStraightFromEndToEnd) {
  const Told told = Tell(WithoutTemperature(60.0, 110.0));
  for (const SensorState& half : told.history.midpoints) {
    ASSERT_TRUE(std::isfinite(half.temperature_degC)) << half.t_s;
    if (!Within(half, 10.0, 110.0)) continue;
    EXPECT_NEAR(half.temperature_degC, 20.0 + kSlope_degC_s * half.t_s, 0.01) << half.t_s;
    EXPECT_NEAR(half.temperature_rate_degC_s, kSlope_degC_s, 1e-3) << half.t_s;
  }
  EXPECT_TRUE(told.history.defects.empty());
}

TEST(TrailWithALongGapOfTemperature, LeavesItOutAndSaysHowLong) {
  const Told told = Tell(WithoutTemperature(60.0, 150.0));
  ASSERT_TRUE(told.history.temperature_known);
  for (std::size_t i = 0; i < told.history.still.size(); ++i) {
    const SensorState& half = told.history.midpoints[2 * i];
    const bool used = told.history.usable[i][2];
    if (Within(half, 62.0, 148.0)) {
      EXPECT_FALSE(used) << half.t_s;
      EXPECT_TRUE(std::isnan(half.temperature_degC) && std::isnan(half.temperature_rate_degC_s));
    } else if (!Within(half, 59.0, 151.0)) {
      EXPECT_TRUE(used) << half.t_s;
    }
    if (used) {
      ASSERT_TRUE(std::isfinite(half.temperature_degC)) << half.t_s;
    }
  }
  ASSERT_EQ(told.history.defects.size(), 1u);
  EXPECT_EQ(told.history.defects[0].kind, "temperature_missing");
  EXPECT_NEAR(told.history.defects[0].first_t_s, 61.0, 0.5);
  EXPECT_NEAR(static_cast<double>(told.history.defects[0].count), 880.0, 20.0) << "0.1 s each";
  EXPECT_THAT(told.history.remarks, ::testing::Contains(HasSubstr("temperature is missing")));
}

// The slope at the end of what is known says nothing of what comes after.
TEST(TrailWithATemperatureThatEnds, ClaimsNoSlopeBeyondTheEnd) {
  const Told told = Tell(WithoutTemperature(130.0, 1e9));
  for (std::size_t i = 0; i < told.history.still.size(); ++i) {
    const SensorState& half = told.history.midpoints[2 * i + 1];
    if (half.t_s < 132.0) continue;
    EXPECT_FALSE(told.history.usable[i][2]);
    EXPECT_TRUE(std::isnan(half.temperature_rate_degC_s));
  }
}

TEST(TrailWithATemperatureThatIsMissingForMostOfTheTime, TakesItAsUnknownAndUsesEverything) {
  const Told told = Tell(WithoutTemperature(60.0, 200.0));
  EXPECT_FALSE(told.history.temperature_known);
  EXPECT_TRUE(told.history.defects.empty());
  for (const auto& usable : told.history.usable) EXPECT_TRUE(usable[2]);
  EXPECT_THAT(told.history.remarks, ::testing::Contains(HasSubstr("less than half")));
}

TEST(TrailOfASlowThermometer, KnowsTheTemperatureBetweenItsReadings) {
  Story story = WithoutTemperature(1e9, 1e9);
  story.temperature_degC = [known = story.temperature_degC](double t_s) {
    return std::fmod(t_s, 8.0) < 0.019 ? known(t_s) : kMissing;
  };
  const Told told = Tell(story);
  ASSERT_TRUE(told.history.temperature_known);
  for (const SensorState& half : told.history.midpoints) {
    if (!Within(half, 10.0, 110.0)) continue;
    EXPECT_NEAR(half.temperature_degC, 20.0 + kSlope_degC_s * half.t_s, 0.01) << half.t_s;
    EXPECT_NEAR(half.temperature_rate_degC_s, kSlope_degC_s, 2e-3) << half.t_s;
  }
}

// What the gyro's noise says before a motion is in the output as well: an angle that follows it
// would show a play in a bench that has none.
TEST(TrailOfATableThatWaitsForItsMotion, IsNotTurnedByTheNoiseOfTheGyro) {
  for (std::uint64_t seed = 1; seed <= 5; ++seed) {
    Story story;
    story.seed = seed;
    story.white_deg_s = 0.1;
    const Told told = Tell(story);
    const std::vector<SensorState>& nodes = told.history.nodes;
    int waits = 0, turned = 0;
    for (std::size_t k = 1; k + 1 < nodes.size(); ++k) {
      // Of neither neighbour, as the ramps of a motion are soft.
      const double before_s = nodes[k - 1].t_s, after_s = nodes[k + 1].t_s;
      if (story.rate_deg_s(before_s) != 0.0 || story.rate_deg_s(nodes[k].t_s) != 0.0) continue;
      if (after_s - before_s > 0.5) continue;
      ++waits;
      const double by_deg = nodes[k].table_by_gyro_deg[2] - nodes[k - 1].table_by_gyro_deg[2];
      turned += by_deg != 0.0 ? 1 : 0;
    }
    EXPECT_GT(waits, 100);
    EXPECT_LE(turned, waits / 100) << "seed " << seed;
  }
}

// Too slowly for the reference's readings, and clearly for the gyro: a play is crossed in it.
TEST(TrailOfATableThatSwingsBackBeforeItRests, FeelsHowFar) {
  constexpr double kBack_deg = 0.06, kBack_s = 0.25, kRest_s = 3.0, kTurn_s = 3.0;
  Story story;
  story.white_deg_s = 0.01;
  const auto rate = story.rate_deg_s, angle = story.angle_deg;
  // Of each turn, from its end on; the next begins where this one has come to rest.
  auto since_turn_s = [=](double t_s) { return std::fmod(t_s, kRest_s + kTurn_s); };
  auto sense = [=](double t_s) {
    const auto turn = static_cast<int>(t_s / (kRest_s + kTurn_s));
    return turn == 0 ? 0.0 : (turn % 2 == 1 ? -1.0 : 1.0);
  };
  story.rate_deg_s = [=](double t_s) {
    const double part = since_turn_s(t_s) / kBack_s;
    const double wave = 1.0 - std::cos(2.0 * std::numbers::pi * part);
    return rate(t_s) + (part < 1.0 ? sense(t_s) * kBack_deg / kBack_s * wave : 0.0);
  };
  story.angle_deg = [=](double t_s) {
    const double part = std::min(1.0, since_turn_s(t_s) / kBack_s);
    const double turned = part - std::sin(2.0 * std::numbers::pi * part) / 2.0 / std::numbers::pi;
    const double before = sense(t_s) == 1.0 ? -kBack_deg : 0.0;
    return angle(t_s) + before + sense(t_s) * kBack_deg * turned;
  };
  const Told told = Tell(story);
  const std::vector<SensorState>& nodes = told.history.nodes;
  auto node_at = [&](double t_s) {
    return std::ranges::find_if(nodes, [=](const SensorState& node) { return node.t_s >= t_s; });
  };
  for (int turn = 1; turn < 20; ++turn) {
    const double end_s = turn * (kRest_s + kTurn_s);
    const auto before = node_at(end_s), after = node_at(end_s + 0.6);
    const double felt_deg = after->table_by_gyro_deg[2] - before->table_by_gyro_deg[2];
    EXPECT_NEAR(felt_deg, story.angle_deg(after->t_s) - story.angle_deg(before->t_s), 0.01)
        << "turn " << turn;
  }
}

// The outer and the inner axis turn at once, a part of either about the other: what the gyro feels
// of one is not a turn of the other.
TEST(TrailOfAxesThatTurnAtOnce, FeelsEachByItself) {
  constexpr double kStep_s = 0.01, kDuration_s = 60.0, kRest_s = 5.0, kTilt_rad = 0.6;
  constexpr double kOuter_deg = 30.0, kOuter_rad_s = 0.5, kInner_deg = 20.0, kInner_rad_s = 1.3;
  auto swing = [](double t_s, double size_deg, double rad_s) {
    const double since_s = std::max(0.0, t_s - kRest_s);
    return std::array{size_deg * (1.0 - std::cos(rad_s * since_s)),
                      size_deg * rad_s * std::sin(rad_s * since_s)};
  };
  MeasurementInfo info;
  info.gyro_present = {true, true, true};
  info.gyro_unit = RateUnit::kDegPerSecond;
  info.reference = ReferenceKind::kStandAngles;
  info.stand_axis_present = {true, true, true};
  calibration::Collector collector;
  collector.OnInfo(info);
  for (double t_s = 0.0; t_s < kDuration_s; t_s += kStep_s) {
    const auto [outer_deg, outer_deg_s] = swing(t_s, kOuter_deg, kOuter_rad_s);
    const auto [inner_deg, inner_deg_s] = swing(t_s, kInner_deg, kInner_rad_s);
    const double inner_rad = inner_deg * std::numbers::pi / 180.0;
    GyroSample sample;
    sample.t_s = t_s;
    sample.xi = {outer_deg_s * std::sin(kTilt_rad) * std::sin(inner_rad),
                 outer_deg_s * std::sin(kTilt_rad) * std::cos(inner_rad),
                 outer_deg_s * std::cos(kTilt_rad) + inner_deg_s};
    collector.OnGyro(sample);
    collector.OnAngle({t_s, 0, outer_deg});
    collector.OnAngle({t_s, 1, kTilt_rad * 180.0 / std::numbers::pi});
    collector.OnAngle({t_s, 2, inner_deg});
  }
  const Recording recording = collector.Take();
  const StateHistory history = MakeStateHistory(recording, {1.0, 1.0, 1.0}, true, {});
  for (const SensorState& node : history.nodes) {
    if (!Within(node, kRest_s + 1.0, kDuration_s - 1.0)) continue;
    EXPECT_NEAR(node.table_by_gyro_deg[2], swing(node.t_s, kInner_deg, kInner_rad_s)[0], 1.0)
        << node.t_s;
    EXPECT_NEAR(node.table_by_gyro_deg[0], swing(node.t_s, kOuter_deg, kOuter_rad_s)[0], 1.0)
        << node.t_s;
  }
}

// The readings of the axes that rest have noise; a rate made of it would be found in the output,
// which has it too.
TEST(TrailOfATableThatTurnsOneAxis, HasNoRateAboutTheOthers) {
  constexpr double kReading_deg = 0.04;
  Motion motion;
  motion.Rest(10.0);
  for (int turn = 0; turn < 10; ++turn) motion.ThereAndBack(kInnerAxis, 60.0, 20.0);
  motion.Rest(10.0);
  BenchSensor sensor;
  sensor.reading_deg = kReading_deg;
  sensor.three_channels = true;
  const Recording recording = SyntheticBench(motion, sensor).Measure({}, 1);
  const StateHistory history = MakeStateHistory(recording, {1.0, 1.0, 1.0}, true, {});
  for (const SensorState& node : history.nodes) {
    EXPECT_NEAR(node.rate_deg_s[0], 0.0, 1e-6) << node.t_s;
    EXPECT_NEAR(node.rate_deg_s[1], 0.0, 1e-6) << node.t_s;
  }
}

// Of a gyro of one axis: the outer axis of a tilted table is felt by the others.
TEST(TrailOfAMotionThatNoChannelCanTell, DoesNotSayThatTheAxisStood) {
  Motion motion;
  motion.Rest(10.0).Turn(kMiddleAxis, 45.0, 20.0).Turn(kOuterAxis, 90.0, 20.0);
  motion.Turn(kInnerAxis, 90.0, 20.0).Rest(5.0);
  const Recording recording = SyntheticBench(motion).Measure({}, 1);
  const StateHistory history = MakeStateHistory(recording, {kMissing, kMissing, 1.0}, true, {});
  const auto& way_deg = history.gyro_turns.back().table_way_deg.back();
  EXPECT_TRUE(std::isnan(way_deg[kOuterAxis]));
  EXPECT_NEAR(way_deg[kInnerAxis], 90.0, 2.0);
}

TEST(TrailOfAMotionThatNoChannelCanTell, FollowsWhatIsFeltAfterIt) {
  constexpr double kTurned_deg = 40.0;
  Motion motion;
  motion.Rest(10.0).Turn(kMiddleAxis, 45.0, 20.0).Turn(kOuterAxis, 90.0, 20.0);
  motion.Turn(kMiddleAxis, -45.0, 20.0).Rest(5.0);
  const double from_s = motion.duration_s() - 1.0;
  motion.Turn(kOuterAxis, kTurned_deg, 20.0).Rest(5.0);
  const Recording recording = SyntheticBench(motion).Measure({}, 1);
  const StateHistory history = MakeStateHistory(recording, {kMissing, kMissing, 1.0}, true, {});
  const auto before = std::ranges::find_if(
      history.nodes, [=](const SensorState& node) { return node.t_s >= from_s; });
  EXPECT_NEAR(
      history.nodes.back().table_by_gyro_deg[kOuterAxis] - before->table_by_gyro_deg[kOuterAxis],
      kTurned_deg, 1.0);
}

// One reading of a coarse encoder alone may be a step off the mean of the others: no motion between
// this measurement and the one before.
TEST(TrailThatBeginsAtRest, HasTheAngleOfItsRestFromTheFirstReadingOn) {
  constexpr double kStep_deg = 360.0 / 4096.0;
  Story story;
  story.reading_deg = 0.0;
  story.reference_hz = 100.0;
  story.gyro_hz = 100.0;
  int readings = 0;
  story.spoil_angle = [&](AngleSample* reading) {
    const bool next_step = ++readings == 1 || readings % 4 == 0;
    reading->angle_deg = kStep_deg * (std::floor(reading->angle_deg / kStep_deg) - next_step);
    return true;
  };
  const Told told = Tell(story);
  EXPECT_NEAR(told.history.nodes[0].table_deg[2], told.history.nodes[5].table_deg[2],
              0.05 * kStep_deg);
}

// A quarter of an hour at rest, then turns of a table whose worm makes a wave of the rate.
Story WithAWormAfterALongRest(double temperature_rate_degC_s) {
  constexpr double kRest_s = 900.0, kWave_Hz = 3.5, kWave_deg_s = 0.3;
  const double turn_rad_s = 2.0 * std::numbers::pi * kWave_Hz;
  Motion motion;
  motion.Rest(kRest_s);
  for (int turn = 0; turn < 4; ++turn) motion.ThereAndBack(kInnerAxis, 160.0, 30.0);
  Story story;
  story.Follow(motion);
  auto turns = [=](double t_s) { return std::fabs(motion.At(t_s).rate_deg_s[kInnerAxis]) > 1.0; };
  const auto rate = story.rate_deg_s, angle = story.angle_deg;
  story.rate_deg_s = [=](double t_s) {
    return rate(t_s) + (turns(t_s) ? kWave_deg_s * std::cos(turn_rad_s * t_s) : 0.0);
  };
  story.angle_deg = [=](double t_s) {
    return angle(t_s) + (turns(t_s) ? kWave_deg_s / turn_rad_s * std::sin(turn_rad_s * t_s) : 0.0);
  };
  story.temperature_degC = [=](double t_s) {
    return 20.0 + temperature_rate_degC_s * std::min(t_s, kRest_s);
  };
  return story;
}

// The readings between two nodes of a turn whose rate swings are not evenly spaced: the gyro says
// where each was made.
TEST(TrailOfAnUnevenTurn, KnowsTheAngleAtEachReading) {
  constexpr double kReference_hz = 100.0;
  Story story = WithAWormAfterALongRest(0.0);
  story.reference_hz = story.gyro_hz = kReference_hz;
  story.white_deg_s = story.reading_deg = 1e-4;
  const Told told = Tell(story);
  int compared = 0;
  for (const SensorState& node : told.history.nodes) {
    const auto off_deg = node.readings_off_mean_deg[kInnerAxis];
    if (off_deg.size() < 3 || std::fabs(node.table_rate_deg_s[kInnerAxis]) < 20.0) continue;
    ++compared;
    double mean_deg = 0.0;
    for (std::size_t i = 0; i < off_deg.size(); ++i)
      mean_deg += story.angle_deg(node.t_s + node.reading_after_s(i)) / double(off_deg.size());
    for (std::size_t i = 0; i < off_deg.size(); ++i) {
      EXPECT_NEAR(off_deg[i], story.angle_deg(node.t_s + node.reading_after_s(i)) - mean_deg, 0.02)
          << "reading " << i << " about " << node.t_s << " s";
    }
  }
  EXPECT_GT(compared, 50);
}

// What a lag makes of a motion is told by how the gyro turned about a reading. A zero-rate offset
// that followed the temperature at rest once passed for noise of the gyro, and the wave for it.
TEST(TrailOfAWaveAfterALongRest, DoesNotDependOnHowTheOffsetDriftedThere) {
  constexpr double kReach_s = calibration::kNear_s.back();
  const Told warming = Tell(WithAWormAfterALongRest(0.04)),
             steady = Tell(WithAWormAfterALongRest(0.0));
  ASSERT_EQ(warming.history.nodes.size(), steady.history.nodes.size());
  int compared = 0;
  for (std::size_t k = 1; k < steady.history.nodes.size(); ++k) {
    if (steady.history.still[k - 1]) continue;
    ++compared;
    // The drift of the last ten seconds of a rest may be in it.
    EXPECT_NEAR(warming.history.gyro_turns[k].near_deg.back()[2],
                steady.history.gyro_turns[k].near_deg.back()[2], 0.01 * kReach_s)
        << "at " << steady.history.nodes[k].t_s << " s";
  }
  EXPECT_GT(compared, 300);
}

Story WithSupply(double begin_s, double end_s) {
  Story story;
  story.duration_s = 240.0;
  story.info.covariates = {"supply_v"};
  story.covariates = {
      [=](double t_s) { return t_s > begin_s && t_s < end_s ? kMissing : 5.0 + 0.01 * t_s; }};
  return story;
}

TEST(TrailWithAGapOfAColumn, BridgesAShortOneAndLeavesOutALongOne) {
  const Told bridged = Tell(WithSupply(60.0, 110.0));
  for (const SensorState& half : bridged.history.midpoints)
    EXPECT_NEAR(half.covariates[0], 5.0 + 0.01 * half.t_s, 2e-3) << half.t_s;
  EXPECT_TRUE(bridged.history.defects.empty());
  const Told missing = Tell(WithSupply(60.0, 150.0));
  ASSERT_EQ(missing.history.defects.size(), 1u);
  EXPECT_EQ(missing.history.defects[0].kind, "column_missing");
  EXPECT_THAT(missing.history.defects[0].where, HasSubstr("supply_v"));
  for (std::size_t i = 0; i < missing.history.still.size(); ++i) {
    if (!missing.history.usable[i][2]) continue;
    EXPECT_NEAR(missing.history.midpoints[2 * i].covariates[0],
                5.0 + 0.01 * missing.history.midpoints[2 * i].t_s, 0.011);
  }
}

SharedColumns ColumnsOf(const Story& story, std::vector<std::string>* remarks) {
  const Recording recording = story.Collect();
  const Recording* const list[] = {&recording};
  return FindSharedColumns(list, remarks);
}

TEST(SharedColumns, RefuseWhatIsMissingForMostOfTheTime) {
  std::vector<std::string> remarks;
  EXPECT_THAT(ColumnsOf(WithSupply(60.0, 150.0), &remarks).names,
              ::testing::ElementsAre("supply_v"));
  EXPECT_TRUE(remarks.empty());
  EXPECT_TRUE(ColumnsOf(WithSupply(60.0, 200.0), &remarks).names.empty());
  EXPECT_THAT(remarks, ::testing::Contains(HasSubstr("supply_v")));
}

TEST(SharedColumns, ListEffectsOfAColumnThatHardlyChangesWithWhatToDo) {
  for (const double swing : {0.0, 1e-3}) {
    Story story;
    story.info.covariates = {"supply_v"};
    story.covariates = {[=](double t_s) { return 5.0 + swing * std::sin(t_s); }};
    std::vector<std::string> remarks;
    const SharedColumns columns = ColumnsOf(story, &remarks);
    EXPECT_EQ(columns.names.size(), swing > 0.0 ? 1u : 0u);
    ASSERT_EQ(columns.unidentifiable.size(), 2u);
    EXPECT_EQ(columns.unidentifiable[0].id, "bias.of(supply_v)");
    EXPECT_EQ(columns.unidentifiable[1].id, "scale.of(supply_v)");
    EXPECT_THAT(columns.unidentifiable[1].settled_by, HasSubstr("vary supply_v"));
  }
}

}  // namespace
}  // namespace gyrobench::testing
