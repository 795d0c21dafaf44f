// Clocks of gyro and reference that part by more than the samples that a reading lies among.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <numbers>
#include <string>
#include <vector>

#include "calibration/state/sensor_state.h"
#include "calibration/trace/trace.h"
#include "tests/calibration/synthetic_bench.h"
#include "tests/calibration/trace_once.h"
#include "tests/calibration/trace_story.h"

namespace gyrobench::testing {
namespace {

using calibration::ChannelTrace;
using calibration::GyroTurn;
using calibration::SensorState;
using calibration::TracedEffect;

// A swing, which differs from a straight line by much within a node's distance.
double SwingAngle(double t_s) { return 10.0 * std::sin(2.0 * std::numbers::pi * 0.6 * t_s); }

std::vector<GyroTurn> NodesOf(double (*angle_deg)(double), double step_s, std::size_t count) {
  std::vector<GyroTurn> turns(count);
  for (std::size_t k = 0; k < count; ++k) {
    turns[k].t_s = 50.0 + static_cast<double>(k) * step_s;
    turns[k].since_first_deg[1] = angle_deg(turns[k].t_s) - angle_deg(50.0);
    for (std::size_t n = 0; n < calibration::kNear_s.size(); ++n)
      turns[k].near_deg[n][1] =
          angle_deg(turns[k].t_s + calibration::kNear_s[n]) - angle_deg(turns[k].t_s);
    for (std::size_t n = 0; n < calibration::kWaySteps; ++n) {
      const double to_go = 1.0 - static_cast<double>(n + 1) / calibration::kWaySteps;
      turns[k].way_deg[n][1] = angle_deg(turns[k].t_s - to_go * step_s) - angle_deg(turns[k].t_s);
    }
  }
  return turns;
}

// The gyro's own noise is in the acceleration that it shows: a lag of the filter and a delay that
// takes it back would be found by it.
TEST(AReferenceThatIsAMillisecondLate, IsOneDelayAndNoFilter) {
  constexpr double kLate_s = 0.001;
  BenchSensor sensor;
  sensor.three_channels = true;
  sensor.angle_random_walk_deg_sqrt_s = 0.005;
  sensor.reading_deg = 0.0005;
  Motion motion = EveryMotion();
  for (int round = 0; round < 6; ++round) {
    for (const TableAxis axis : {kInnerAxis, kMiddleAxis, kOuterAxis})
      motion.Swing(axis, 60.0, 0.12, 6).Rest(2.0);
  }
  const SyntheticBench bench(motion, sensor);
  for (std::uint64_t seed = 1; seed <= 3; ++seed) {
    Injection late;
    late.shown_s = [=](double t_s) { return t_s - kLate_s; };
    const calibration::Recording recording = bench.Measure(late, seed);
    const calibration::Recording* const inputs[] = {&recording};
    calibration::TraceOptions options;
    options.curves = false;
    for (const ChannelTrace& channel : calibration::Trace(inputs, options).result.channels) {
      for (const TracedEffect& effect : channel.effects) {
        EXPECT_NE(effect.id, "bandwidth.first_order") << channel.summary << ", seed " << seed;
        if (effect.id != "angle.latency") continue;
        EXPECT_NEAR(effect.parameters.at(0).value, -kLate_s,
                    4.5 * effect.parameters.at(0).std_error);
      }
    }
  }
}

TEST(HowFarTheGyroTurnedOn, IsKnownAcrossTheNodesAround) {
  for (const double step_s : {0.02, 0.1, 0.2}) {
    const std::vector<GyroTurn> turns = NodesOf(SwingAngle, step_s, 41);
    SensorState point;
    point.gyro_turns = turns;
    point.node = 20;
    const double t_s = turns[20].t_s;
    for (double tau_s = -0.35; tau_s < 0.35; tau_s += 0.0037) {
      EXPECT_NEAR(calibration::TurnedOn(point, 1, tau_s), SwingAngle(t_s + tau_s) - SwingAngle(t_s),
                  2e-3)
          << "nodes " << step_s << " s apart, tau " << tau_s << " s";
    }
  }
}

TEST(HowFarTheGyroTurnedOn, GoesOnAtTheRateOfTheLastNode) {
  const std::vector<GyroTurn> turns = NodesOf([](double t_s) { return 7.0 * t_s; }, 0.1, 5);
  SensorState point;
  point.gyro_turns = turns;
  for (const std::size_t node : {0u, 4u}) {
    point.node = node;
    for (const double tau_s : {-1.0, -0.5, 0.5, 1.0})
      EXPECT_NEAR(calibration::TurnedOn(point, 1, tau_s), 7.0 * tau_s, 1e-6);
  }
}

TEST(HowFarTheGyroTurnedOn, IsNotKnownWhereThereIsNoNode) {
  EXPECT_TRUE(std::isnan(calibration::TurnedOn(SensorState(), 2, 0.01)));
}

// At the end the clocks are 0.2 s apart, which is a good part of each ramp.
TEST(ClocksThatPart, AreNamedAloneAfterHalfAnHour) {
  Motion motion;
  for (int round = 0; round < 5; ++round) {
    for (const double rate : {10.0, 25.0, 50.0}) motion.ThereAndBack(kInnerAxis, 180.0, rate);
    motion.Rest(350.0);
  }
  constexpr double kPpm = 100.0;
  for (std::uint64_t seed = 1; seed <= 4; ++seed) {
    for (const double eps : {kPpm * 1e-6, -kPpm * 1e-6}) {
      Story story;
      story.Follow(motion);
      story.UseTurningChannelAlone();
      story.seed = seed;
      story.rate_deg_s = [&](double t_s) {
        return (1.0 + eps) * motion.At((1.0 + eps) * t_s).rate_deg_s[kInnerAxis];
      };
      const calibration::ChannelTrace channel = TraceOf(story.Collect());
      ASSERT_EQ(channel.effects.size(), 1u) << channel.summary << ", seed " << seed;
      EXPECT_EQ(channel.effects[0].id, "angle.clock_drift") << channel.summary;
      const auto& parameter = channel.effects[0].parameters.at(0);
      EXPECT_NEAR(std::fabs(parameter.value), kPpm, 4.0 * parameter.std_error);
    }
  }
}

// Turns that are hardly more than two ramps, as the procedure `scale` makes them: the delay is a
// good part of each, and of the distance of two nodes.
TEST(ALateReference, OfShortTurnsIsADelayAndNothingElse) {
  Motion motion;
  for (int turn = 0; turn < 40; ++turn) {
    motion.Turn(kInnerAxis, turn % 20 < 10 ? 12.0 : -12.0, 20.0);
    motion.Rest(1.0);
  }
  std::uint64_t seed = 100;
  for (const double delay_s : {-0.15, -0.06, -0.02, 0.03, 0.08, 0.15}) {
    Story story;
    story.Follow(motion);
    story.UseTurningChannelAlone();
    story.gyro_hz = 200.0;
    story.reference_hz = 50.0;
    story.seed = ++seed;
    story.rate_deg_s = [&](double t_s) { return motion.At(t_s - delay_s).rate_deg_s[kInnerAxis]; };
    const calibration::ChannelTrace channel = TraceOf(story.Collect());
    ASSERT_FALSE(channel.effects.empty()) << channel.summary << ", " << delay_s << " s";
    for (const auto& effect : channel.effects) {
      EXPECT_EQ(effect.id, "angle.latency") << channel.summary << ", " << delay_s << " s";
      EXPECT_NEAR(effect.parameters.at(0).value, delay_s, 3e-4);
    }
  }
}

// What a delay explains is 1e6 of -2 log L and more here: a ten-thousandth of that would hide what
// stands at seven standard errors.
TEST(ALateReference, HidesNoSmallEffectAndNamesNoneForTheShapeOfItsFilter) {
  const Motion motion = ManySpeeds();
  constexpr double kDelay_s = 0.025, kAsymmetry = 2e-4;
  const auto late_deg_s = [&](double t_s, double by_s) {
    return motion.At(t_s - by_s).rate_deg_s[kInnerAxis];
  };
  for (std::uint64_t seed = 1; seed <= 4; ++seed) {
    Story story;
    story.Follow(motion);
    story.UseTurningChannelAlone();
    story.seed = seed;
    story.rate_deg_s = [&](double t_s) {
      const double rate_deg_s = late_deg_s(t_s, kDelay_s);
      return rate_deg_s + kAsymmetry * std::fabs(rate_deg_s);
    };
    const ChannelTrace hidden = TraceOf(story.Collect());
    EXPECT_TRUE(std::ranges::any_of(hidden.effects,
                                    [](const TracedEffect& effect) {
                                      return effect.id == "scale.asymmetry" ||
                                             std::ranges::find(effect.rivals, "scale.asymmetry") !=
                                                 effect.rivals.end();
                                    }))
        << hidden.summary << ", seed " << seed;
    // As late in the mean, by 15 ms more and less: neither a delay nor a lag of first order.
    story.rate_deg_s = [&](double t_s) {
      return 0.5 * (late_deg_s(t_s, kDelay_s - 0.015) + late_deg_s(t_s, kDelay_s + 0.015));
    };
    const ChannelTrace filtered = TraceOf(story.Collect());
    for (const TracedEffect& effect : filtered.effects)
      EXPECT_TRUE(effect.id == "angle.latency" || effect.id == "bandwidth.first_order")
          << filtered.summary << ", seed " << seed;
  }
}

// Turns of `scale` in which the other channels feel the axis by their cross-axis part.
Story FeltAcross(const Motion& motion) {
  Story story;
  story.Follow(motion);
  story.gyro_hz = 200.0;
  story.reference_hz = 50.0;
  story.scale = {0.05, -0.04, 1.012};
  return story;
}

void ExpectThatOnlyZNames(const calibration::TraceResult& result, const std::string& id) {
  const double noise_deg = Story().white_deg_s / std::sqrt(200.0) * std::sqrt(10.0);
  ASSERT_EQ(result.channels.size(), 3u);
  for (const calibration::ChannelTrace& channel : result.channels) {
    if (channel.axis == SensorAxis::kZ) {
      EXPECT_FALSE(channel.effects.empty()) << channel.summary;
      for (const auto& effect : channel.effects) EXPECT_EQ(effect.id, id) << channel.summary;
    } else {
      EXPECT_TRUE(channel.effects.empty()) << channel.summary;
      // In 10 s, of what the gyro's noise alone makes there.
      EXPECT_LT(channel.heldout_angle_rms_deg.after, 2.0 * noise_deg) << channel.summary;
    }
  }
}

// An error of the reference that one channel has found is in the cross-axis part of the others,
// where it would pass for tones and curves.
TEST(WhatOneChannelShowsOfTheReference, IsTakenOffTheCrossAxisPartOfTheOthers) {
  Motion motion;
  motion.Rest(60.0);
  for (int turn = 0; turn < 60; ++turn) {
    motion.Turn(kInnerAxis, turn % 20 < 10 ? 12.0 : -12.0, 20.0);
    motion.Rest(1.0);
  }
  Story late = FeltAcross(motion);
  constexpr double kDelay_s = -0.12;
  late.rate_deg_s = [&](double t_s) { return motion.At(t_s - kDelay_s).rate_deg_s[kInnerAxis]; };
  ExpectThatOnlyZNames(TraceAll(late.Collect()), "angle.latency");

  Story rippled = FeltAcross(motion);
  rippled.angle_deg = [&](double t_s) {
    const double angle_deg = motion.At(t_s).angle_deg[kInnerAxis];
    return angle_deg + 0.05 * std::sin(100.0 * angle_deg * std::numbers::pi / 180.0);
  };
  ExpectThatOnlyZNames(TraceAll(rippled.Collect()), "angle.ripple");
}

// Two delays are one: what the gyro is late by at a time is their sum, and neither makes up for an
// error in the shape of the other.
TEST(ADelayBesideADrift, AddsToItInTime) {
  Motion motion;
  motion.Rest(60.0);
  for (int turn = 0; turn < 120; ++turn) {
    motion.Turn(kInnerAxis, turn % 20 < 10 ? 12.0 : -12.0, 20.0);
    motion.Rest(turn % 20 == 19 ? 100.0 : 1.0);
  }
  // The second drift adds up to a few milliseconds.
  for (const double delay_s : {-0.09, 0.06}) {
    for (const double eps : {-5e-5, 4e-6}) {
      Story story;
      story.Follow(motion);
      story.UseTurningChannelAlone();
      story.gyro_hz = 200.0;
      story.reference_hz = 50.0;
      story.rate_deg_s = [&](double t_s) {
        return (1.0 - eps) * motion.At((1.0 - eps) * t_s - delay_s).rate_deg_s[kInnerAxis];
      };
      const calibration::ChannelTrace channel = TraceOf(story.Collect());
      const double end_s = story.duration_s;
      double found_s = 0.0, at_end_s = 0.0;
      for (const auto& effect : channel.effects) {
        const double value = effect.parameters.at(0).value;
        EXPECT_TRUE(effect.id == "angle.latency" || effect.id == "angle.clock_drift")
            << channel.summary;
        if (effect.id == "angle.latency") found_s += value;
        if (effect.id == "angle.clock_drift") at_end_s += 1e-6 * value * end_s;
      }
      at_end_s += found_s;
      EXPECT_EQ(channel.effects.size(), 2u) << channel.summary;
      EXPECT_NEAR(found_s, delay_s, 5e-4) << channel.summary;
      EXPECT_NEAR(at_end_s, delay_s + eps * end_s, 5e-4) << channel.summary;
    }
  }
}

// At full speed the readings of a node span two of its periods, and their mean has next to nothing
// of it: what there is comes from the ramps, where each reading turns by another angle.
TEST(ARippleOfManyPeriods, IsNamedAloneWhereANodesReadingsSpanItsPeriods) {
  Motion motion;
  for (int turn = 0; turn < 60; ++turn) {
    motion.Turn(kInnerAxis, turn % 20 < 10 ? 12.0 : -12.0, 20.0);
    motion.Rest(1.0);
  }
  for (const double periods : {180.0, 240.0, 360.0}) {
    constexpr double kSize_deg = 0.02;
    Story story;
    story.Follow(motion);
    story.UseTurningChannelAlone();
    story.gyro_hz = 200.0;
    story.reference_hz = 50.0;
    story.reading_deg = 0.002;
    story.angle_deg = [&](double t_s) {
      const double angle_deg = motion.At(t_s).angle_deg[kInnerAxis];
      return angle_deg + kSize_deg * std::sin(periods * angle_deg * std::numbers::pi / 180.0);
    };
    const calibration::ChannelTrace channel = TraceOf(story.Collect());
    ASSERT_EQ(channel.effects.size(), 1u) << channel.summary << ", " << periods << " periods";
    EXPECT_EQ(channel.effects[0].id, "angle.ripple") << channel.summary;
    const auto& parameters = channel.effects[0].parameters;
    EXPECT_NEAR(parameters.at(0).value, kSize_deg, 4.0 * parameters.at(0).std_error);
    EXPECT_NEAR(parameters.back().value, periods, 0.1);
  }
}

}  // namespace
}  // namespace gyrobench::testing
