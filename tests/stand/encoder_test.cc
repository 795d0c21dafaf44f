#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "stand/angle_encoder.h"
#include "tests/stand/test_stand.h"

namespace gyrobench::stand {
namespace {

config::EncoderScenario IdealEncoder() { return config::IdealScenario().encoder[0]; }
AxisMechanics IdealAxis(double play_deg = 0.0) {
  return {config::IdealScenario().mechanics[0], play_deg, 40.0, 10000.0};
}
AngleEncoder MakeEncoder(const config::EncoderScenario& scenario,
                         const config::EncoderConfig& config = TestAxis("inner", 3).encoder) {
  return {scenario, config, 40.0, 1234};
}

void MoveTo(AxisMechanics& axis, double t_s, double table_deg, double rpm = 400) {
  MoveCommand command = TestMove(rpm);
  command.target = Pulses(table_deg);
  axis.Move(t_s, command);
}

TEST(Encoder, CountsAreTheAngleInTheStandFilesConvention) {
  config::EncoderConfig config = TestAxis("inner", 3).encoder;
  config.map.range_counts = 1 << 20;
  for (const int sign : {1, -1}) {
    config.sign = sign;
    config.offset_deg = 12.5;
    AxisMechanics axis = IdealAxis();
    MoveTo(axis, 0, -100);
    const double counts = MakeEncoder(IdealEncoder(), config).Counts(60, axis);
    const double angle = sign * counts * 360 / (1 << 20) + 12.5;
    EXPECT_NEAR(std::remainder(angle + 100, 360), 0.0, 360.0 / (1 << 20));
  }
}

TEST(Encoder, ItsLatencyIsTheRateTimesTheLatency) {
  auto scenario = IdealEncoder();
  scenario.latency_s = 0.004;
  AxisMechanics axis = IdealAxis();
  MoveTo(axis, 0, 360, 100);
  const double ahead = axis.TableAngle(5.0) - MakeEncoder(scenario).Reading_deg(5.0, axis);
  EXPECT_NEAR(ahead, 0.004 * 15.0, 1e-4);
}

TEST(Encoder, ADriftingClockMakesTheLatencyGrow) {
  auto scenario = IdealEncoder();
  scenario.latency_s = 0.004;
  scenario.clock_drift_rel = 1e-4;
  AxisMechanics axis = IdealAxis();
  MoveTo(axis, 100, 360, 100);
  const double ahead = axis.TableAngle(105.0) - MakeEncoder(scenario).Reading_deg(105.0, axis);
  EXPECT_NEAR(ahead, (0.004 + 0.0105) * 15.0, 1e-4);
}

TEST(Encoder, EccentricityIsASineOfTheTablesAngle) {
  auto scenario = IdealEncoder();
  scenario.eccentricity_1_deg = 0.03;
  scenario.eccentricity_1_phase_deg = 40;
  scenario.eccentricity_2_deg = 0.01;
  const AngleEncoder encoder = MakeEncoder(scenario);
  AxisMechanics axis = IdealAxis();
  MoveTo(axis, 0, 360);
  for (double t = 0; t < 8; t += 0.1) {
    const double phi = axis.TableAngle(t);
    const double rad = std::numbers::pi / 180;
    const double expected = 0.03 * std::sin((phi + 40) * rad) + 0.01 * std::sin(2 * phi * rad);
    EXPECT_NEAR(encoder.Reading_deg(t, axis) - phi, expected, 1e-4);
  }
}

TEST(Encoder, OnTheShaftItSeesNoWormAndNoPlay) {
  auto scenario = IdealEncoder();
  scenario.side = config::EncoderScenario::Side::kShaft;
  config::MechanicsScenario mechanics = config::IdealScenario().mechanics[0];
  mechanics.worm_1_deg = 0.1;
  mechanics.backlash_deg = 0.3;
  AxisMechanics axis(mechanics, 0.0, 40.0, 10000.0);
  MoveTo(axis, 0, 9);
  EXPECT_NEAR(MakeEncoder(scenario).Reading_deg(60, axis), 9.0, 1e-9);
  EXPECT_GT(std::abs(axis.TableAngle(60) - 9.0), 0.1);
}

TEST(Encoder, PlayInItsCouplingShowsAtReversals) {
  AxisMechanics axis = IdealAxis(0.04);
  const AngleEncoder encoder = MakeEncoder(IdealEncoder());
  MoveTo(axis, 0, 9);
  EXPECT_NEAR(encoder.Reading_deg(20, axis), 9 - 0.02, 1e-9);
  MoveTo(axis, 20, 4.5);
  EXPECT_NEAR(encoder.Reading_deg(40, axis), 4.5 + 0.02, 1e-9);
}

TEST(Encoder, ItsNoiseHasItsStandardDeviationAndBelongsToTheValueNotToTheReading) {
  auto scenario = IdealEncoder();
  scenario.noise_deg = 0.01;
  scenario.refresh_s = 1e-3;
  const AngleEncoder encoder = MakeEncoder(scenario);
  const AxisMechanics axis = IdealAxis();
  double sum = 0.0;
  const int kCount = 20000;
  for (int i = 0; i < kCount; ++i) {
    const double reading = encoder.Reading_deg(1e-3 * i + 2e-4, axis);
    EXPECT_EQ(reading, encoder.Reading_deg(1e-3 * i + 7e-4, axis));
    sum += reading * reading;
  }
  EXPECT_NEAR(std::sqrt(sum / kCount), 0.01, 4 * 0.01 / std::sqrt(2.0 * kCount));
}

TEST(Encoder, ScaleErrorZeroAndStepAddUp) {
  auto scenario = IdealEncoder();
  scenario.scale_rel = 0.001;
  scenario.zero_deg = 0.5;
  scenario.step_at_s = 30;
  scenario.step_deg = 0.25;
  AxisMechanics axis = IdealAxis();
  MoveTo(axis, 0, 90);
  EXPECT_NEAR(MakeEncoder(scenario).Reading_deg(29, axis), 90.09 + 0.5, 1e-9);
  EXPECT_NEAR(MakeEncoder(scenario).Reading_deg(31, axis), 90.09 + 0.75, 1e-9);
}

}  // namespace
}  // namespace gyrobench::stand
