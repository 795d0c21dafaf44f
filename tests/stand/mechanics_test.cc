#include "stand/mechanics.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <vector>

#include "tests/stand/test_stand.h"

namespace gyrobench::stand {
namespace {

config::MechanicsScenario IdealMechanics() { return config::IdealScenario().mechanics[2]; }

AxisMechanics MakeAxis(const config::MechanicsScenario& scenario, double encoder_play_deg = 0.0) {
  return {scenario, encoder_play_deg, 40.0, 10000.0};
}

// Starts a move and says when it ends.
double Move(AxisMechanics& axis, double t_s, double table_deg, double rpm = 133) {
  MoveCommand command = TestMove(rpm);
  command.target = static_cast<std::int64_t>(std::llround(axis.Pulses(t_s))) + Pulses(table_deg);
  axis.Move(t_s, command);
  double end = t_s;
  while (!axis.RestsFrom(end)) end += 0.01;
  return end;
}

TEST(Mechanics, OneTurnOfTheShaftTurnsAPerfectTableByNineDegrees) {
  AxisMechanics axis = MakeAxis(IdealMechanics());
  MoveCommand command = TestMove(100);
  command.target = 10000;
  axis.Move(1.0, command);
  EXPECT_NEAR(axis.TableAngle(100.0), 9.0, 1e-12);
  EXPECT_EQ(axis.TableAngle(0.5), 0.0);
}

TEST(Mechanics, BacklashIsTakenUpOnceAfterAReversalAndNeverElsewhere) {
  auto scenario = IdealMechanics();
  scenario.backlash_deg = 0.05;
  AxisMechanics axis = MakeAxis(scenario);
  double t = Move(axis, 0.0, 9.0);
  EXPECT_NEAR(axis.TableAngle(t), 9.0 - 0.025, 1e-12);
  t = Move(axis, t, 9.0);
  EXPECT_NEAR(axis.TableAngle(t), 18.0 - 0.025, 1e-12);
  t = Move(axis, t, -9.0);
  EXPECT_NEAR(axis.TableAngle(t), 9.0 + 0.025, 1e-12);
  t = Move(axis, t, -0.045);  // within the play: the table stays
  EXPECT_NEAR(axis.TableAngle(t), 8.955 + 0.025, 1e-9);
  t = Move(axis, t, 0.045);
  EXPECT_NEAR(axis.TableAngle(t), 8.955 + 0.025, 1e-9);
}

TEST(Mechanics, TheTableStandsStillWhileThePlayIsTakenUp) {
  auto scenario = IdealMechanics();
  scenario.backlash_deg = 1.0;
  AxisMechanics axis = MakeAxis(scenario);
  const double t = Move(axis, 0.0, 9.0);
  const double before = axis.TableAngle(t);
  const double end = Move(axis, t, -9.0);
  bool moved = false;
  for (double now = t; now < end; now += 1e-3) {
    const double lag = axis.At(now).shaft_deg - axis.TableAngle(now);
    EXPECT_LE(std::abs(lag), 0.5 + 1e-9);
    moved |= axis.TableAngle(now) < before - 1e-9;
    if (moved) {
      EXPECT_NEAR(lag, -0.5, 1e-9);
    }
  }
}

TEST(Mechanics, TheWormErrorRepeatsWithEachTurnOfTheShaft) {
  auto scenario = IdealMechanics();
  scenario.worm_1_deg = 0.02;
  scenario.worm_2_deg = 0.01;
  scenario.worm_1_phase_deg = 33;
  AxisMechanics axis = MakeAxis(scenario);
  const double end = Move(axis, 0.0, 27.0);
  const double first = axis.TableAngle(-1.0);
  EXPECT_NEAR(axis.TableAngle(end) - first, 27.0, 1e-9);
  double most = 0.0;
  double first_harmonic = 0.0;
  const int kSteps = 20000;
  for (int i = 0; i < kSteps; ++i) {
    const AxisTruth truth = axis.At(end * i / kSteps);
    const double error = truth.table_deg - truth.shaft_deg;
    const double psi = truth.shaft_deg * 40 * std::numbers::pi / 180;
    const double expected =
        0.02 * std::sin(psi + 33 * std::numbers::pi / 180) + 0.01 * std::sin(2 * psi);
    first_harmonic = std::max(first_harmonic, std::abs(error - expected));
    most = std::max(most, std::abs(error));
  }
  EXPECT_LT(first_harmonic, 1e-9);
  EXPECT_GT(most, 0.02);
}

TEST(Mechanics, ThePastCanBeAskedInAnyOrder) {
  auto scenario = config::Scenario{}.mechanics[0];
  scenario.backlash_deg = 0.3;
  AxisMechanics axis = MakeAxis(scenario, 0.1);
  double t = Move(axis, 0.0, 3.0);
  t = Move(axis, t, -2.0);
  std::vector<double> forwards;
  for (double now = 0; now < t; now += 0.01) forwards.push_back(axis.At(now).coupled_deg);
  std::vector<double> backwards;
  for (std::size_t i = forwards.size(); i-- > 0;) {
    backwards.push_back(axis.At(0.01 * static_cast<double>(i)).coupled_deg);
  }
  std::ranges::reverse(backwards);
  for (std::size_t i = 0; i < forwards.size(); ++i) EXPECT_NEAR(forwards[i], backwards[i], 1e-7);
}

TEST(Mechanics, LostStepsMoveTheTableButNotTheDrivesCount) {
  AxisMechanics axis = MakeAxis(IdealMechanics());
  const double end = Move(axis, 0.0, 9.0);
  axis.Lose(0.4, 200);
  EXPECT_EQ(axis.Pulses(end), 10000);
  EXPECT_NEAR(axis.TableAngle(end), 9.0 - 200 * 9.0 / 10000, 1e-9);
}

TEST(Mechanics, StepsThatAreLostAtRestAreLostInTheNextMotion) {
  AxisMechanics axis = MakeAxis(IdealMechanics());
  Move(axis, 0.0, 9.0);
  axis.Lose(5.0, 100);
  EXPECT_NEAR(axis.TableAngle(10.0), 9.0, 1e-12);
  const double end = Move(axis, 10.0, -9.0);
  EXPECT_NEAR(axis.TableAngle(end), 100 * 9.0 / 10000, 1e-9);
}

TEST(Mechanics, WhatIsDraggedMissesItsShareOfTheDrivesCountForGood) {
  for (const double part : {1.0, 0.25}) {
    AxisMechanics axis = MakeAxis(IdealMechanics());
    const double end = Move(axis, 0.0, 90.0);
    const double half_way = axis.TableAngle(3.0);
    axis.Drag(3.0, 4.0, part);
    const double expected = 90.0 - part * (axis.Pulses(4.0) - axis.Pulses(3.0)) * 9.0 / 10000;
    EXPECT_EQ(axis.TableAngle(3.0), half_way);
    if (part == 1.0) {
      EXPECT_NEAR(axis.TableAngle(3.9), half_way, 1e-9);
    }
    EXPECT_EQ(axis.Pulses(end), 100000);
    EXPECT_NEAR(axis.TableAngle(end), expected, 1e-9);
    // Far more moves than the axis remembers change nothing of it.
    double t_s = end + 1.0;
    for (int i = 0; i < 40; ++i) t_s = Move(axis, t_s, i % 2 == 0 ? 9.0 : -9.0) + 1.0;
    EXPECT_NEAR(axis.TableAngle(t_s), expected, 1e-9);
  }
}

TEST(Mechanics, WhatRunsAwayTurnsUnknownToTheDriveUntilItIsStopped) {
  AxisMechanics axis = MakeAxis(IdealMechanics());
  axis.RunAway(2.0, 100.0, 5.0);
  EXPECT_FALSE(axis.RestsFrom(1.0));
  EXPECT_NEAR(axis.TableAngle(4.0), 10.0, 1e-9);
  EXPECT_EQ(axis.Pulses(4.0), 0);
  EXPECT_FALSE(axis.Moving(4.0));
  axis.Stop(5.0, 50.0);
  EXPECT_NEAR(axis.TableAngle(50.0), 15.0, 1e-9);
  EXPECT_TRUE(axis.RestsFrom(5.0));
}

TEST(Mechanics, AMotorAcceleratedBeyondItsTorqueSlipsWholeElectricalPeriods) {
  auto scenario = IdealMechanics();
  scenario.pull_out_rpm_per_s = 4000;  // TestMove asks 10000
  AxisMechanics axis = MakeAxis(scenario);
  const double end = Move(axis, 0.0, 9.0);
  const double lost_periods = (9.0 - axis.TableAngle(end)) / (360.0 / 40 / 50);
  EXPECT_GT(lost_periods, 0.5);
  EXPECT_NEAR(lost_periods, std::round(lost_periods), 1e-9);
}

TEST(Mechanics, VibrationPeaksAtTheResonanceAndIsHalfAtItsWidth) {
  auto scenario = IdealMechanics();
  scenario.resonance_vibration_g = 0.3;
  scenario.resonance_deg_s = 15.0;  // 100 rpm
  scenario.resonance_width_deg_s = 1.5;
  const auto at_rpm = [&](double rpm) {
    AxisMechanics axis = MakeAxis(scenario);
    MoveCommand command = TestMove(rpm);
    command.target = 100000;
    axis.Move(0.0, command);
    return axis.Vibration(2.0);
  };
  EXPECT_NEAR(at_rpm(100), 0.09, 1e-9);
  EXPECT_NEAR(at_rpm(110), 0.045, 1e-9);
  EXPECT_NEAR(at_rpm(90), 0.045, 1e-9);
  EXPECT_EQ(MakeAxis(scenario).Vibration(0.0), 0.0);
}

TEST(Mechanics, AQuickStopKeepsTheTablesAngleContinuous) {
  AxisMechanics axis = MakeAxis(config::Scenario{}.mechanics[0]);
  MoveCommand command = TestMove(200);
  command.target = 100000;
  axis.Move(0.0, command);
  const double before = axis.TableAngle(1.0);
  axis.Stop(1.0, 50.0);
  EXPECT_NEAR(axis.TableAngle(1.0), before, 1e-9);
  EXPECT_TRUE(axis.RestsFrom(1.1));
  EXPECT_EQ(axis.Pulses(2.0), std::round(axis.Pulses(2.0)));
}

}  // namespace
}  // namespace gyrobench::stand
