// Manoeuvres foreseen, and the choice among them.
#include "calibration/plan/next_manoeuvre.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "base/error.h"

namespace gyrobench::calibration {
namespace {

using ::testing::Contains;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::Not;
using ::testing::Pair;
using ::testing::SizeIs;

constexpr double kUnits = 131.0;

ForeseenMove Move(StandAxis axis, double begin_s, double from_deg, double to_deg,
                  double rate_deg_s) {
  return {axis, begin_s, from_deg, to_deg, rate_deg_s, 80.0};
}

// There and back about the inner axis with the middle one where it stands.
Manoeuvre Turns(const std::string& name, double middle_deg, std::vector<double> rates_deg_s,
                double angle_deg = 180.0) {
  Manoeuvre out;
  out.name = name;
  out.begin_deg = {0.0, middle_deg, 0.0};
  double now_s = 5.0;
  for (const double rate : rates_deg_s) {
    for (const bool back : {false, true}) {
      out.moves.push_back(
          Move(StandAxis::kInner, now_s, back ? angle_deg : 0.0, back ? 0.0 : angle_deg, rate));
      now_s += angle_deg / rate + rate / 80.0 + 3.0;
    }
  }
  out.duration_s = now_s + 2.0;
  return out;
}

Recording Nothing() {
  Recording recording;
  recording.info.gyro_present = {true, true, true};
  recording.info.accel_present = {true, true, true};
  recording.info.temperature_present = true;
  recording.info.gyro_units_per_deg_s = kUnits;
  recording.info.reference = ReferenceKind::kStandAngles;
  recording.info.stand_axis_present = {true, true, true};
  recording.info.site_latitude_deg = 50.0;
  recording.info.gear_ratio = 40.0;
  recording.info.power_on = "one";
  Node node;
  node.temperature_degC = 25.0;
  recording.columns.nodes.push_back(node);
  return recording;
}

Recording Recorded(const Manoeuvre& manoeuvre) {
  return Foresee(manoeuvre, Nothing(), {kUnits, kUnits, kUnits});
}

Traced Verdict(std::vector<ModelTerm> terms, double noise = 1.0) {
  Traced traced;
  ChannelTrace channel;
  channel.axis = SensorAxis::kZ;
  channel.noise = {0.0035 * noise, 1e-4 * noise, 0.005 * noise};
  ChannelModel model;
  model.axis = SensorAxis::kZ;
  model.units_per_deg_s = kUnits;
  for (const ModelTerm& term : terms) {
    TracedEffect effect;
    effect.id = term.id;
    effect.origin = term.origin;
    channel.effects.push_back(effect);
  }
  model.terms = std::move(terms);
  traced.result.channels.push_back(channel);
  traced.models.push_back(model);
  return traced;
}

ModelTerm Term(const std::string& id, std::vector<double> coefficients) {
  ModelTerm term;
  term.id = id;
  term.coefficients = std::move(coefficients);
  term.reference_degC = 25.0;
  return term;
}

TEST(ForeseenMove, GoesFromEndToEndWithinItsRateAndItsAcceleration) {
  constexpr double kStep_s = 1e-3;
  for (const double way_deg : {-360.0, -3.0, 0.5, 90.0}) {
    const ForeseenMove move = {StandAxis::kInner, 0.0, 10.0, 10.0 + way_deg, 20.0, 80.0};
    EXPECT_EQ(AngleOf(move, -1.0), 10.0);
    EXPECT_EQ(AngleOf(move, 1000.0), 10.0 + way_deg);
    double last_rate = 0.0;
    for (double t_s = 0.0; t_s < 20.0; t_s += kStep_s) {
      const double rate = (AngleOf(move, t_s + kStep_s) - AngleOf(move, t_s)) / kStep_s;
      EXPECT_LE(std::fabs(rate), 20.0 + 1e-6);
      EXPECT_GE(rate * way_deg, -1e-6);
      EXPECT_LE(std::fabs(rate - last_rate), 80.0 * kStep_s * (1 + 1e-6));
      last_rate = rate;
    }
  }
}

TEST(Foresee, TheGyroTurnsWithTheReferenceInEveryPose) {
  for (const double middle_deg : {0.0, 40.0, 90.0, 180.0}) {
    Manoeuvre manoeuvre = Turns("turns", middle_deg, {20.0});
    manoeuvre.moves.pop_back();  // and does not come back
    manoeuvre.moves.push_back(Move(StandAxis::kOuter, 18.0, 0.0, 30.0, 10.0));
    const Recording recording = Recorded(manoeuvre);
    const std::vector<Node>& nodes = recording.columns.nodes;
    ASSERT_GT(nodes.size(), 100U);
    for (std::size_t c = 0; c < 3; ++c) {
      const double felt = (nodes.back().at.z[c] - nodes.front().at.z[c]) / kUnits;
      const double turned = nodes.back().rotation_deg[c] - nodes.front().rotation_deg[c];
      EXPECT_NEAR(felt, turned, 0.05) << "channel " << c << ", middle " << middle_deg;
    }
  }
}

TEST(Foresee, TimeGoesOnAndAFanMovesTheTemperatureByWhatItIsSaidTo) {
  const Recording before = Recorded(Turns("before", 0.0, {20.0}));
  Manoeuvre cooled = Turns("cooled", 0.0, {20.0});
  cooled.duration_s = 1200.0;
  cooled.warms_degC = -8.0;
  const Recording after = Foresee(cooled, before, {kUnits, kUnits, kUnits});
  EXPECT_GT(after.first_time_s, before.last_time_s);
  EXPECT_NEAR(after.columns.nodes.back().temperature_degC,
              before.columns.nodes.back().temperature_degC - 8.0, 0.1);
}

TEST(NextManoeuvre, AnEffectSeenInOnePoseAsksForAnother) {
  // Gain that depends on gravity: with z up it is the scale factor's.
  const Traced traced = Verdict({Term("scale.g", {0.0, 0.0, 2e-3})});
  const Recording so_far = Recorded(Turns("so far", 0.0, {10.0, 20.0, 30.0}));
  const std::vector<Manoeuvre> menu = {Turns("up", 0.0, {10.0, 20.0, 30.0}),
                                       Turns("down", 180.0, {10.0, 20.0, 30.0})};
  const NextManoeuvre next = ChooseManoeuvre(so_far, traced, menu);
  EXPECT_FALSE(next.settled);
  ASSERT_TRUE(next.best.has_value());
  EXPECT_EQ(menu[*next.best].name, "down");
  EXPECT_THAT(next.worths[1].because, HasSubstr("scale.g"));
}

TEST(NextManoeuvre, OneSpeedAsksForSeveral) {
  const Traced traced = Verdict({Term("scale.asymmetry", {1e-3})});
  const Recording so_far = Recorded(Turns("so far", 0.0, {20.0}));
  const std::vector<Manoeuvre> menu = {Turns("one", 0.0, {20.0, 20.0, 20.0}),
                                       Turns("three", 0.0, {5.0, 20.0, 40.0})};
  const NextManoeuvre next = ChooseManoeuvre(so_far, traced, menu);
  EXPECT_FALSE(next.settled);
  ASSERT_TRUE(next.best.has_value());
  EXPECT_EQ(menu[*next.best].name, "three");
  EXPECT_THAT(next.open, HasSubstr("scale.quadratic_even"));
}

TEST(NextManoeuvre, WhatIsFarBeyondTheNoiseIsSettledAndWithMoreNoiseItIsNot) {
  const Recording so_far = Recorded(Turns("so far", 0.0, {5.0, 10.0, 20.0, 30.0, 40.0}));
  const std::vector<Manoeuvre> menu = {Turns("more", 0.0, {5.0, 20.0, 40.0})};
  const std::vector<ModelTerm> asymmetry = {Term("scale.asymmetry", {3e-2})};
  EXPECT_TRUE(ChooseManoeuvre(so_far, Verdict(asymmetry), menu).settled);
  EXPECT_FALSE(ChooseManoeuvre(so_far, Verdict(asymmetry, 300.0), menu).settled);
}

TEST(NextManoeuvre, WithNothingNamedItAsksForWhatIsLeastKnownAndNothingIsSettled) {
  const Recording so_far = Recorded(Turns("so far", 0.0, {20.0}));
  Manoeuvre rest = Turns("rest", 0.0, {});
  rest.duration_s = 60.0;
  const std::vector<Manoeuvre> menu = {rest, Turns("level", 90.0, {10.0, 40.0})};
  const NextManoeuvre next = ChooseManoeuvre(so_far, Verdict({}), menu);
  EXPECT_FALSE(next.settled);
  ASSERT_TRUE(next.best.has_value());
  EXPECT_EQ(menu[*next.best].name, "level");
}

TEST(NextManoeuvre, ADescriptionWithoutACauseIsNotSettled) {
  ModelTerm curve = Term("empirical(T)", {0.0, 1.0});
  curve.origin = EffectOrigin::kEmpirical;
  const std::vector<Manoeuvre> menu = {Turns("more", 0.0, {5.0, 20.0, 40.0})};
  const NextManoeuvre next =
      ChooseManoeuvre(Recorded(Turns("so far", 0.0, {20.0})), Verdict({curve}), menu);
  EXPECT_FALSE(next.settled);
  EXPECT_THAT(next.open, HasSubstr("empirical(T)"));
}

TEST(NextManoeuvre, WhatIsNotJudgedIsNotSettled) {
  const Recording so_far = Recorded(Turns("so far", 0.0, {5.0, 10.0, 20.0, 30.0, 40.0}));
  const std::vector<Manoeuvre> menu = {Turns("more", 0.0, {5.0, 20.0, 40.0})};
  const std::vector<ModelTerm> asymmetry = {Term("scale.asymmetry", {3e-2})};
  Traced unknown_noise = Verdict(asymmetry);
  unknown_noise.result.channels[0].noise.reference_deg = kMissing;
  EXPECT_FALSE(ChooseManoeuvre(so_far, unknown_noise, menu).settled);
  ModelTerm supply = Term("bias.of", {1.0});
  supply.covariate = "supply_v";
  EXPECT_FALSE(ChooseManoeuvre(so_far, Verdict({supply}), menu).settled);
  // Faint, and nothing to tell it by.
  EXPECT_FALSE(ChooseManoeuvre(so_far, Verdict({Term("scale.asymmetry", {1e-5})}), {}).settled);
}

TEST(NextManoeuvre, WhatTheDataDoNotTellApartIsOpenWhateverWasToBeExpected) {
  const Recording so_far = Recorded(Turns("so far", 0.0, {5.0, 10.0, 20.0, 30.0, 40.0}));
  const std::vector<Manoeuvre> menu = {Turns("more", 0.0, {5.0, 20.0, 40.0})};
  Traced traced = Verdict({Term("scale.asymmetry", {3e-2})});
  traced.result.channels[0].effects[0].rivals = {"scale.quadratic_even"};
  const NextManoeuvre next = ChooseManoeuvre(so_far, traced, menu);
  EXPECT_FALSE(next.settled);
  EXPECT_THAT(next.open, HasSubstr("z: scale.asymmetry or scale.quadratic_even"));
}

// Of the effects in their order: how much larger the angle error is without each.
void SetShares(Traced* traced, const std::vector<double>& before) {
  std::vector<TracedEffect>& effects = traced->result.channels[0].effects;
  for (std::size_t i = 0; i < before.size(); ++i)
    effects[i].heldout_angle_rms_deg = {before[i], 1.0, {}};
}

TEST(ShareOfError, AddsInSquaresAndIsNothingWhereTheErrorDoesNotGrow) {
  TracedEffect effect;
  EXPECT_TRUE(std::isnan(ShareOfError(effect)));
  for (const double share : {0.0, 0.3, 4.0}) {
    effect.heldout_angle_rms_deg = {2.0 * std::hypot(1.0, share), 2.0, {}};
    EXPECT_NEAR(ShareOfError(effect), share, 1e-12);
  }
  effect.heldout_angle_rms_deg = {0.9, 1.0, {}};
  EXPECT_EQ(ShareOfError(effect), 0.0);
}

TEST(NextManoeuvre, WhatIsOpenOfASmallEffectIsSaidAndHoldsNothingUp) {
  const Recording so_far = Recorded(Turns("so far", 0.0, {20.0, 40.0}));
  const std::vector<Manoeuvre> menu = {Turns("other speeds", 0.0, {5.0, 30.0})};
  Traced traced = Verdict({Term("scale.asymmetry", {1.0}), Term("scale.g", {0.0, 0.0, 1e-6})});
  traced.result.channels[0].effects[1].rivals = {"angle.clock_drift"};
  SetShares(&traced, {2.0, 1.02});
  LoopMemory memory;
  const NextManoeuvre next = ChooseManoeuvre(so_far, traced, menu, memory, 0.3);
  EXPECT_THAT(next.open, Not(HasSubstr("scale.g or")));
  EXPECT_THAT(next.small_pairs, HasSubstr("z: scale.g or angle.clock_drift"));
  EXPECT_THAT(next.small, ElementsAre(Pair("z", "scale.g")));
  EXPECT_THAT(next.worths[0].because, Not(HasSubstr("tells scale.g")));
  // It may yet become large: nothing of it is closed, hopeless as it is.
  EXPECT_THAT(next.never, Not(HasSubstr("scale.g or")));
  EXPECT_THAT(memory.closed, Not(Contains(HasSubstr("scale.g or"))));
}

TEST(NextManoeuvre, NothingIsSmallWhereAllIsOrWhereEveryEffectCounts) {
  const Recording so_far = Recorded(Turns("so far", 0.0, {20.0, 40.0}));
  Traced traced = Verdict({Term("scale.asymmetry", {1.0}), Term("scale.g", {0.0, 0.0, 1.0})});
  const auto small = [&](double small_below) {
    LoopMemory memory;
    return ChooseManoeuvre(so_far, traced, {}, memory, small_below).small;
  };
  SetShares(&traced, {1.01, 1.02});
  EXPECT_THAT(small(0.3), IsEmpty());
  SetShares(&traced, {2.0, 0.99});
  EXPECT_THAT(small(0.3), SizeIs(1));
  EXPECT_THAT(small(0.0), IsEmpty());
}

TEST(NextManoeuvre, AnIdIsSmallWhereAllEffectsOfItAre) {
  const Recording so_far = Recorded(Turns("so far", 0.0, {20.0, 40.0}));
  Traced traced =
      Verdict({Term("scale.asymmetry", {1.0}), Term("bias.step", {1.0}), Term("bias.step", {1.0})});
  const auto small = [&] {
    LoopMemory memory;
    return ChooseManoeuvre(so_far, traced, {}, memory, 0.3).small;
  };
  SetShares(&traced, {2.0, 2.0, 1.01});
  EXPECT_THAT(small(), IsEmpty());
  SetShares(&traced, {2.0, 1.01, 1.01});
  EXPECT_THAT(small(), SizeIs(1));
  SetShares(&traced, {1.01, 1.01, 1.01});
  EXPECT_THAT(small(), IsEmpty());
}

TEST(NextManoeuvre, WhatMayOnlyBePositiveIsNoRivalOfWhatWouldTakeANegativeOne) {
  const Recording so_far = Recorded(Turns("so far", 0.0, {20.0, 40.0}));
  const std::vector<Manoeuvre> menu = {Turns("again", 0.0, {20.0})};
  const auto spoken_of = [&](double latency_s) {
    ModelTerm latency = Term("angle.latency", {latency_s});
    latency.nonlinear = {latency_s};
    const NextManoeuvre next = ChooseManoeuvre(so_far, Verdict({latency}), menu);
    return next.open + next.never;
  };
  EXPECT_THAT(spoken_of(0.002), HasSubstr("bandwidth.first_order"));
  EXPECT_THAT(spoken_of(-0.002), Not(HasSubstr("bandwidth.first_order")));
}

TEST(NextManoeuvre, WhatTheMenuWouldNeverTellApartDoesNotCount) {
  // Both grow with the rate alone, and one more turn at the same rate tells nothing of it.
  const Recording so_far = Recorded(Turns("so far", 0.0, {20.0, 20.0}));
  const std::vector<Manoeuvre> menu = {Turns("again", 0.0, {20.0})};
  const NextManoeuvre next =
      ChooseManoeuvre(so_far, Verdict({Term("scale.asymmetry", {3e-4})}), menu);
  EXPECT_THAT(next.never, HasSubstr("scale.quadratic_even"));
  EXPECT_THAT(next.open, ::testing::Not(HasSubstr("scale.quadratic_even")));
}

// A pair that no manoeuvre separates in the time that is left takes no bench time.
TEST(NextManoeuvre, WhatTheTimeLeftWouldNotTellApartIsClosedSaidOnceAndNotAskedForAgain) {
  const Recording so_far = Recorded(Turns("so far", 0.0, {20.0}));
  const std::vector<Manoeuvre> menu = {Turns("three", 0.0, {5.0, 20.0, 40.0})};
  const Traced traced = Verdict({Term("scale.asymmetry", {1e-3})});
  LoopMemory memory;
  EXPECT_THAT(ChooseManoeuvre(so_far, traced, menu, memory).open,
              HasSubstr("scale.quadratic_even"));
  EXPECT_TRUE(memory.closed.empty());
  memory.left_min = 0.001;
  const NextManoeuvre late = ChooseManoeuvre(so_far, traced, menu, memory);
  EXPECT_THAT(late.newly_closed, HasSubstr("z: scale.asymmetry or scale.quadratic_even"));
  memory.left_min = 1000.0;
  const NextManoeuvre again = ChooseManoeuvre(so_far, traced, menu, memory);
  EXPECT_EQ(again.newly_closed, "");
  EXPECT_THAT(again.never, HasSubstr("z: scale.asymmetry or scale.quadratic_even"));
  EXPECT_THAT(again.open, ::testing::Not(HasSubstr("scale.quadratic_even")));
  EXPECT_THAT(again.worths[0].because, ::testing::Not(HasSubstr("from scale.quadratic_even")));
}

// The expectation may be wrong, and the loop must end all the same.
TEST(NextManoeuvre, APairIsClosedWhenWhatWasMadeForItDidNotTellItApart) {
  const Recording so_far = Recorded(Turns("so far", 0.0, {5.0, 10.0, 20.0, 30.0, 40.0}));
  const std::vector<Manoeuvre> menu = {Turns("more", 0.0, {5.0, 20.0, 40.0})};
  Traced traced = Verdict({Term("scale.asymmetry", {3e-2})});
  traced.result.channels[0].effects[0].rivals = {"scale.quadratic_even"};
  LoopMemory memory;
  int manoeuvres = 0;
  while (!ChooseManoeuvre(so_far, traced, menu, memory).settled && manoeuvres < 100) ++manoeuvres;
  EXPECT_GE(manoeuvres, 2) << "given up at once";
  EXPECT_LE(manoeuvres, 8);
  EXPECT_THAT(ChooseManoeuvre(so_far, traced, menu, memory).never,
              HasSubstr("z: scale.asymmetry or scale.quadratic_even"));
}

TEST(NextManoeuvre, WhatThereIsNoTimeForIsWeighedAndNotChosen) {
  const Traced traced = Verdict({Term("scale.g", {0.0, 0.0, 2e-3})});
  const Recording so_far = Recorded(Turns("so far", 0.0, {10.0, 20.0, 30.0}));
  std::vector<Manoeuvre> menu = {Turns("up", 0.0, {10.0, 20.0, 30.0}),
                                 Turns("down", 180.0, {10.0, 20.0, 30.0})};
  menu[1].affordable = false;
  const NextManoeuvre next = ChooseManoeuvre(so_far, traced, menu);
  EXPECT_GT(next.worths[1].nats, 0.0);
  EXPECT_NE(next.best, std::optional<std::size_t>(1));
  EXPECT_FALSE(next.settled);
}

TEST(NextManoeuvre, AManoeuvreOfNoDurationAndASensorWithoutThermometerAreNoTrouble) {
  Recording so_far = Nothing();
  so_far.info.temperature_present = false;
  so_far.columns.nodes.clear();
  so_far = Foresee(Turns("so far", 0.0, {10.0, 20.0}), so_far, {kUnits, kUnits, kUnits});
  const std::vector<Manoeuvre> menu = {Manoeuvre(), Turns("more", 90.0, {10.0, 40.0})};
  const NextManoeuvre next = ChooseManoeuvre(so_far, Verdict({}), menu);
  ASSERT_TRUE(next.best.has_value());
  EXPECT_EQ(*next.best, 1U);
  for (const ManoeuvreWorth& worth : next.worths) EXPECT_TRUE(std::isfinite(worth.nats_per_min));
}

TEST(NextManoeuvre, AReferenceThatIsNoStandIsRefused) {
  Recording recording = Recorded(Turns("so far", 0.0, {20.0}));
  recording.info.reference = ReferenceKind::kSensorAngle;
  EXPECT_THROW(ChooseManoeuvre(recording, Verdict({}), {}), DataError);
}

}  // namespace
}  // namespace gyrobench::calibration
