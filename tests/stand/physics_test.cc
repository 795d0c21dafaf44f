// The bench as a whole: what the unit measures against what the axes do.
#include <gtest/gtest.h>

#include <cmath>
#include <numeric>
#include <random>

#include "base/error.h"
#include "stand/bench_physics.h"
#include "tests/stand/test_stand.h"

namespace gyrobench::stand {
namespace {

constexpr std::size_t kOuter = 0, kMiddle = 1, kInner = 2;

config::Scenario Ideal() { return config::IdealScenario(); }

// So little noise that its sum over some seconds is small, and enough to dither the counts: at a
// constant rate quantisation alone would add up.
constexpr double kDither_deg_sqrt_s = 3e-4;
config::Scenario Dithered() {
  config::Scenario scenario = Ideal();
  scenario.gyro.angle_random_walk_deg_sqrt_s.fill(kDither_deg_sqrt_s);
  return scenario;
}

double Integral(const std::vector<Sample>& samples, std::size_t axis, double period_s) {
  return std::accumulate(samples.begin(), samples.end(), 0.0, [&](double sum, const Sample& s) {
    return sum + s.rate_deg_s[axis] * period_s;
  });
}

// Whatever the motion, worm error, play and filter: at rest before and after, the rates add up to
// the angle.
TEST(Physics, TheIntegralOfTheRateIsTheAngleForRandomMoves) {
  std::mt19937_64 random(5);
  config::Scenario scenario = Dithered();
  scenario.mechanics[kInner] = config::MechanicsScenario{};
  for (int i = 0; i < 20; ++i) {
    Physics physics(TestStand(), scenario, 1, kStart);
    std::uniform_real_distribution<double> angle(-40, 40);
    double t = 0.2;
    std::vector<Sample> samples = ReadSamples(physics, 0, t);
    const double before = physics.Truth(kInner, At(t)).table_deg;
    for (int k = 0; k < 3; ++k) {
      physics.MoveBy(kInner, At(t), Pulses(angle(random)), TestMove(150));
      const double next = t + 1.0;  // cuts the first two moves short with a new one
      const auto more = ReadSamples(physics, t, k < 2 ? next : t + 12.0);
      samples.insert(samples.end(), more.begin(), more.end());
      t = next;
    }
    const double turned = physics.Truth(kInner, At(t + 20)).table_deg - before;
    EXPECT_NEAR(Integral(samples, 2, 0.005), turned, 4.5 * kDither_deg_sqrt_s * std::sqrt(14.0));
  }
}

TEST(Physics, TurningTheOuterAxisWithTheMiddleOneTiltedIsFeltWithCosineAndSine) {
  Physics physics(TestStand(), Dithered(), 1, kStart);
  physics.MoveBy(kMiddle, At(0.0), Pulses(30), TestMove(200));
  ReadSamples(physics, 0, 5);
  physics.MoveBy(kOuter, At(5.0), Pulses(-60), TestMove(100));
  const auto samples = ReadSamples(physics, 5, 15);
  const double tolerance = 4.5 * kDither_deg_sqrt_s * std::sqrt(10.0);
  EXPECT_NEAR(Integral(samples, 2, 0.005), -60 * std::cos(30 * std::numbers::pi / 180), tolerance);
  EXPECT_NEAR(Integral(samples, 1, 0.005), -60 * std::sin(30 * std::numbers::pi / 180), tolerance);
  EXPECT_NEAR(samples.back().accel_g[2], std::cos(30 * std::numbers::pi / 180), 1e-4);
  EXPECT_NEAR(samples.back().accel_g[1], std::sin(30 * std::numbers::pi / 180), 1e-4);
}

TEST(Physics, AtRestTheMeanRateIsTheEarths) {
  config::Scenario scenario = Ideal();
  scenario.site.earth_rate = true;
  // White noise dithers the counts, which are coarser than the Earth's rate.
  scenario.gyro.angle_random_walk_deg_sqrt_s = {0.001, 0.001, 0.001};
  Physics physics(TestStand(), scenario, 1, kStart);
  const auto samples = ReadSamples(physics, 0, 1000);
  const double n = static_cast<double>(samples.size());
  const double w = 15.041 / 3600;
  const double rad = std::numbers::pi / 180;
  const double tolerance = 4 * 0.001 / std::sqrt(1000.0);
  EXPECT_NEAR(Integral(samples, 0, 1 / n), w * std::cos(52 * rad) * std::cos(30 * rad), tolerance);
  EXPECT_NEAR(Integral(samples, 1, 1 / n), -w * std::cos(52 * rad) * std::sin(30 * rad), tolerance);
  EXPECT_NEAR(Integral(samples, 2, 1 / n), w * std::sin(52 * rad), tolerance);
}

TEST(Physics, TheFilterDelaysTheRateByTheDataSheetsDelay) {
  Physics physics(TestStand(), Ideal(), 1, kStart);
  physics.WithGyro(At(0),
                   [](GyroSampler& gyro, double t) { gyro.Set(t, {.filter = 4, .divider = 0}); });
  physics.MoveBy(kInner, At(0.1), Pulses(300), TestMove(600, 2000));  // 45 deg/s^2 for 1 s
  const auto samples = ReadSamples(physics, 0, 1.2);
  double delay = 0.0;
  int count = 0;
  for (const Sample& sample : samples) {
    const double t = 0.001 * (sample.number + 1);
    if (t < 0.4 || t > 1.1) continue;
    const double slope = 600.0 * 6 / 40 / 1.2;
    delay += t - (0.1 + sample.rate_deg_s[2] / slope);
    ++count;
  }
  EXPECT_NEAR(delay / count, 0.0083, 2e-4);
}

TEST(Physics, CountsAreWholeAndSaturateAtTheirEnds) {
  config::Scenario scenario = Ideal();
  scenario.gyro.bias_deg_s = {400.0, -400.0, 0.5};
  Physics physics(TestStand(), scenario, 1, kStart);
  const auto samples = ReadSamples(physics, 0, 0.1);
  EXPECT_EQ(samples.back().rate_deg_s[0], 32767 / 131.0);
  EXPECT_EQ(samples.back().rate_deg_s[1], -32768 / 131.0);
  EXPECT_EQ(samples.back().rate_deg_s[2], std::round(0.5 * 131) / 131);
}

TEST(Physics, AnotherRangeScalesTheCounts) {
  config::Scenario scenario = Ideal();
  scenario.gyro.bias_deg_s = {400.0, 0, 0};
  Physics physics(TestStand(), scenario, 1, kStart);
  physics.WithGyro(At(0.05), [](GyroSampler& gyro, double t) { gyro.Set(t, {.range = 1}); });
  EXPECT_NEAR(ReadSamples(physics, 0.05, 0.2).back().rate_deg_s[0], 400.0, 0.01);
}

TEST(Physics, TheSensorsClockSetsTheNumberOfSamplesAndTheTicksTellTheUnitsTime) {
  config::Scenario scenario = Ideal();
  scenario.gyro.sample_clock_rel = 0.01;
  scenario.unit.tick_rel = -0.0025;
  Physics physics(TestStand(), scenario, 1, kStart);
  const auto samples = ReadSamples(physics, 0, 100);
  EXPECT_NEAR(static_cast<double>(samples.size()), 100 * 200 * 1.01, 1.5);
  const double ticks = samples.back().tick - samples.front().tick;
  const double seconds = (samples.back().number - samples.front().number) / (200 * 1.01);
  EXPECT_NEAR(ticks / seconds / 250000, 1 - 0.0025, 1e-7);
}

TEST(Physics, TheTickDriftsAsTheScenarioSays) {
  config::Scenario scenario = Ideal();
  scenario.unit.tick_drift_rel_per_h = 0.001;
  Physics physics(TestStand(), scenario, 1, kStart);
  const auto tick_at = [&](double t_s) {
    return physics.WithGyro(At(t_s), [](GyroSampler& gyro, double t) { return gyro.TickAt(t); });
  };
  const std::uint32_t before = tick_at(1800);
  const double ticks = tick_at(3600) - before;
  EXPECT_NEAR(ticks / 1800 / 250000 - 1, 0.001 * 0.75, 1e-6);
}

std::vector<Sample> RunBusy(double poll_s, std::uint64_t seed, bool read_encoders) {
  const config::Scenario scenario = DrawSpecimen(config::Scenario{}, 3);
  Physics physics(TestStand(), scenario, seed, kStart);
  std::vector<Sample> all;
  for (int k = 0; k < 6; ++k) {
    physics.MoveBy(k % 2 == 0 ? kInner : kMiddle, At(k), Pulses(7.0 * (k % 3 - 1) + 2),
                   TestMove(180));
    const auto more = ReadSamples(physics, k, k + 1, poll_s);
    all.insert(all.end(), more.begin(), more.end());
    if (read_encoders) physics.EncoderCounts(kInner, At(k + 1));
  }
  return all;
}

void ExpectSame(const std::vector<Sample>& a, const std::vector<Sample>& b) {
  ASSERT_GT(a.size(), 1000U);
  std::size_t i = 0;
  for (const Sample& sample : b) {
    while (i < a.size() && a[i].number < sample.number) ++i;
    ASSERT_LT(i, a.size());
    ASSERT_EQ(a[i].tick, sample.tick);
    ASSERT_EQ(a[i].rate_deg_s, sample.rate_deg_s);
    ASSERT_EQ(a[i].accel_g, sample.accel_g);
    ASSERT_EQ(a[i].temperature_degC, sample.temperature_degC);
  }
}

TEST(Physics, SamplesDoNotDependOnWhoPollsWhatAndWhen) {
  const auto often = RunBusy(0.007, 1, true);
  ExpectSame(often, RunBusy(0.25, 1, false));
}

TEST(Physics, AnotherSeedGivesOtherNoise) {
  const auto a = RunBusy(0.1, 1, false);
  const auto b = RunBusy(0.1, 2, false);
  int same = 0;
  for (std::size_t i = 0; i < a.size(); ++i) same += a[i].rate_deg_s == b[i].rate_deg_s;
  EXPECT_LT(same, 20);
}

TEST(Physics, ARebootStartsNumbersAndTicksAnew) {
  config::Scenario scenario = Ideal();
  scenario.faults = {{.at_s = 1.0, .device = "gyro", .kind = config::FaultScenario::Kind::kReboot}};
  Physics physics(TestStand(), scenario, 1, kStart);
  const int boots = physics.WithGyro(At(0.9), [](auto& gyro, double) { return gyro.boot_count(); });
  physics.WithGyro(At(2.1), [&](GyroSampler& gyro, double t) {
    EXPECT_EQ(gyro.boot_count(), boots + 1);
    EXPECT_EQ(gyro.next_number(), 200U);  // 1 s after 0.1 s of booting
    EXPECT_NEAR(gyro.TickAt(t), 1.0 * 250000, 2);
  });
}

TEST(Physics, AFrozenSensorRepeatsItsLastSample) {
  config::Scenario scenario;
  scenario.faults = {{.at_s = 1.0,
                      .duration_s = 0.5,
                      .device = "gyro",
                      .kind = config::FaultScenario::Kind::kFrozen}};
  Physics physics(TestStand(), scenario, 1, kStart);
  const auto samples = ReadSamples(physics, 0.5, 2);
  int frozen = 0;
  for (std::size_t i = 1; i < samples.size(); ++i) {
    frozen += samples[i].rate_deg_s == samples[i - 1].rate_deg_s &&
              samples[i].accel_g == samples[i - 1].accel_g;
  }
  EXPECT_NEAR(frozen, 100, 2);
}

TEST(Physics, ASaturatedSensorReadsTheEndOfItsRange) {
  config::Scenario scenario;
  scenario.faults = {{.at_s = 1.0,
                      .device = "gyro",
                      .kind = config::FaultScenario::Kind::kSaturation,
                      .amount = -1}};
  Physics physics(TestStand(), scenario, 1, kStart);
  for (const Sample& sample : ReadSamples(physics, 1.1, 1.5)) {
    for (const double rate : sample.rate_deg_s) EXPECT_EQ(rate, -32768 / 131.0);
  }
}

TEST(Physics, AnOverheatedSensorIsHotterAtLastByTheAmount) {
  config::Scenario scenario = Ideal();
  scenario.faults = {
      {.device = "gyro", .kind = config::FaultScenario::Kind::kOverheating, .amount = 40}};
  Physics physics(TestStand(), scenario, 1, kStart);
  const auto samples = ReadSamples(physics, 5000, 5000.2);
  ASSERT_FALSE(samples.empty());
  EXPECT_NEAR(samples.back().temperature_degC, scenario.room.temperature_degC + 40, 0.1);
}

TEST(Physics, AClockThatJumpsShowsInTheTicksOnceAndInNothingElse) {
  config::Scenario scenario = Ideal();
  scenario.faults = {{.at_s = 1.0,
                      .device = "gyro",
                      .kind = config::FaultScenario::Kind::kClockJump,
                      .amount = 0.5}};
  Physics physics(TestStand(), scenario, 1, kStart);
  const auto samples = ReadSamples(physics, 0.5, 1.5);
  int jumps = 0;
  for (std::size_t i = 1; i < samples.size(); ++i) {
    EXPECT_EQ(samples[i].number, samples[i - 1].number + 1);
    const std::uint32_t ticks = samples[i].tick - samples[i - 1].tick;
    if (ticks == 1250) continue;
    EXPECT_NEAR(ticks, 1250 + 125000, 1);
    ++jumps;
  }
  EXPECT_EQ(jumps, 1);
}

TEST(Physics, LostSamplesAreCountedAndLeaveAGapInTheTicksOnly) {
  config::Scenario scenario = Ideal();
  scenario.unit.lost_sample_probability = 0.1;
  Physics physics(TestStand(), scenario, 1, kStart);
  const auto samples = ReadSamples(physics, 0, 100);
  double gaps = 0.0;
  for (std::size_t i = 1; i < samples.size(); ++i) {
    EXPECT_EQ(samples[i].number, samples[i - 1].number + 1);
    gaps += (samples[i].tick - samples[i - 1].tick) / 1250.0 - 1.0;
  }
  const auto lost =
      physics.WithGyro(At(100), [](auto& gyro, double) { return gyro.samples_lost(); });
  EXPECT_NEAR(lost, 2000, 200);
  EXPECT_NEAR(gaps, lost, 5);
}

TEST(Physics, AnAlarmStopsTheMotionWhetherAnyoneLooksOrNot) {
  config::Scenario scenario = Ideal();
  scenario.faults = {{.at_s = 1.0,
                      .device = "inner.drive",
                      .kind = config::FaultScenario::Kind::kAlarm,
                      .amount = 0x1A}};
  Physics physics(TestStand(), scenario, 1, kStart);
  physics.MoveBy(kInner, At(0), Pulses(360), TestMove(100));
  const auto drive = physics.Drive(kInner, At(30));
  EXPECT_EQ(drive.alarm, 0x1A);
  EXPECT_FALSE(drive.moving);
  EXPECT_NEAR(physics.Truth(kInner, At(30)).table_deg, 15.0, 0.2);  // 1 s at 15 deg/s
  physics.MoveBy(kInner, At(31), Pulses(5), TestMove(100));
  EXPECT_FALSE(physics.Drive(kInner, At(31.1)).moving);
  physics.ClearAlarm(kInner, At(32));
  physics.MoveBy(kInner, At(33), Pulses(5), TestMove(100));
  EXPECT_TRUE(physics.Drive(kInner, At(33.1)).moving);
}

TEST(Physics, AGyroMapWithoutItsTablesIsRefused) {
  config::StandConfig stand = TestStand();
  stand.gyro.map.filter_delay_s.clear();
  EXPECT_THROW(Physics(stand, Ideal(), 1, kStart), ConfigError);
}

TEST(Specimen, TheSameSeedGivesTheSamePartAndAnotherSeedAnother) {
  const config::Scenario scenario;
  EXPECT_EQ(DrawSpecimen(scenario, 5).gyro.scale_rel, DrawSpecimen(scenario, 5).gyro.scale_rel);
  EXPECT_NE(DrawSpecimen(scenario, 5).gyro.scale_rel, DrawSpecimen(scenario, 6).gyro.scale_rel);
}

TEST(Specimen, ItsSpreadIsTheScenarios) {
  double sum = 0.0;
  const int kParts = 2000;
  for (std::uint64_t seed = 0; seed < kParts; ++seed) {
    sum += std::pow(DrawSpecimen(config::Scenario{}, seed).gyro.scale_rel[1], 2);
  }
  EXPECT_NEAR(std::sqrt(sum / kParts), 0.015, 0.001);
}

TEST(Specimen, WhatIsGivenIsTheMiddleOfWhatIsDrawnAndAnIdealPartHasNoSpread) {
  config::Scenario scenario = config::IdealScenario();
  scenario.gyro.scale_rel = {0.01, -0.02, 0.03};
  const config::Scenario specimen = DrawSpecimen(scenario, 99);
  EXPECT_EQ(specimen.gyro.scale_rel, scenario.gyro.scale_rel);
  EXPECT_EQ(specimen.gyro.cross_axis_rel, config::Square{});
  EXPECT_EQ(specimen.unit.tick_rel, 0.0);
}

}  // namespace
}  // namespace gyrobench::stand
