// Every effect of the catalogue by an independent formula: put into a measurement made up by plain
// mathematics, named by the trace, its numbers within the interval that the trace states.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cctype>
#include <cmath>
#include <functional>
#include <numbers>
#include <ostream>
#include <string>
#include <vector>

#include "calibration/effects/effect.h"
#include "calibration/trace/trace.h"
#include "tests/calibration/injected.h"
#include "tests/calibration/synthetic_bench.h"
#include "tests/calibration/trace_once.h"

namespace gyrobench::testing {
namespace {

using calibration::ChannelTrace;
using calibration::TracedEffect;

constexpr double kPi = std::numbers::pi, kRad = kPi / 180.0;

struct Row {
  std::string id;
  std::string note;  // what is special about the row, for the name of its test
  Injection (*make)(const SyntheticBench& bench);
  std::vector<Expected> parameters;
  Motion (*motion)() = EveryMotion;
  BenchSensor sensor = {};
  bool with_supply = false;
  bool after_another_run = false;  // of the same motion, without the effect
};

void PrintTo(const Row& row, std::ostream* out) { *out << row.id; }

double Inner(const BenchState& s) { return s.table.angle_deg[kInnerAxis] * kRad; }

// --- Effects of gravity and temperature on the bias.

Injection GLinear(const SyntheticBench&) {
  return Rate([](const BenchState& s) { return 0.02 * s.g[0] - 0.03 * s.g[1] + 0.01 * s.g[2]; });
}
Injection GSquared(const SyntheticBench&) {
  return Rate([](const BenchState& s) { return 0.02 * s.g[0] * s.g[0] - 0.01 * s.g[1] * s.g[1]; });
}
Injection TemperatureRate(const SyntheticBench&) {
  return Rate([](const BenchState& s) { return 0.2 * s.temperature_rate_degC_s; });
}
// What lags behind the temperature by a play of 1 degC, and follows when that is used up.
// `before_degC`: how much cooler the package was when it last turned back.
template <int kBefore_tenths_degC>
Injection Hysteresis(const SyntheticBench& bench) {
  const double begin_degC = bench.At(0.0).temperature_degC;
  return Rate([held = begin_degC - 0.1 * kBefore_tenths_degC](const BenchState& s) mutable {
    constexpr double kPlay_degC = 1.0;
    const double ahead = s.temperature_degC - held;
    if (ahead > kPlay_degC) held = s.temperature_degC - kPlay_degC;
    if (ahead < -kPlay_degC) held = s.temperature_degC + kPlay_degC;
    return 0.02 * (held - s.temperature_degC);
  });
}
Injection WarmUp(const SyntheticBench&) {
  return Rate([](const BenchState& s) { return 0.1 * std::exp(-s.t_s / 30.0); });
}

// --- Effects on the scale factor.

Injection ScaleG(const SyntheticBench&) {
  return Rate(
      [](const BenchState& s) { return Wz(s) * (4e-4 * s.g[0] - 3e-4 * s.g[1] + 5e-4 * s.g[2]); });
}
Injection ScaleTemperature(const SyntheticBench&) {
  return Rate([](const BenchState& s) { return 1e-4 * Wz(s) * (s.temperature_degC - 25.0); });
}
Injection QuadraticOdd(const SyntheticBench&) {
  return Rate([](const BenchState& s) { return std::copysign(2e-5 * Wz(s) * Wz(s), Wz(s)); });
}
Injection Cubic(const SyntheticBench&) {
  return Rate([](const BenchState& s) { return 6e-7 * std::pow(Wz(s), 3.0); });
}
Injection QuadraticEven(const SyntheticBench&) {
  return Rate([](const BenchState& s) { return -1e-5 * std::pow(Wz(s), 2.0); });
}
// Another scale factor for each sign.
Injection Asymmetry(const SyntheticBench&) {
  return Rate([](const BenchState& s) { return Wz(s) > 0.0 ? 4e-4 * Wz(s) : -4e-4 * Wz(s); });
}

// --- Effects of other quantities.

// The mean square of a sine is half its amplitude's square.
Injection Vibration(const SyntheticBench&) {
  return Rate([](const BenchState& s) { return 4.0 * s.vibration_g * s.vibration_g / 2.0; });
}
Injection Resonance(const SyntheticBench&) {
  return Rate([](const BenchState& s) {
    constexpr double kAmplitude = 0.05, kAt = 12.7, kWidth = 2.4;
    const double off = (std::fabs(Wz(s)) - kAt) / kWidth;
    return Wz(s) == 0.0 ? 0.0 : kAmplitude / (1.0 + off * off);
  });
}
Injection BiasOfSupply(const SyntheticBench&) {
  return Rate([](const BenchState& s) { return 0.2 * (s.supply_v - 5.0); });
}
Injection ScaleOfSupply(const SyntheticBench&) {
  return Rate([](const BenchState& s) { return 0.004 * (s.supply_v - 5.0) * Wz(s); });
}
// 15.041 deg/h at 48 deg north, world x 30 deg west of north: (north, west, up).
constexpr std::array<double, 3> kEarth_deg_s = {0.0024212, -0.0013979, 0.0031049};
Injection EarthRate(const SyntheticBench&) {
  return Rate([](const BenchState& s) {
    double sum = 0.0;
    for (std::size_t c = 0; c < 3; ++c) sum += s.z_axis_in_world[c] * kEarth_deg_s[c];
    return sum;
  });
}
Injection BiasStep(const SyntheticBench&) {
  return Rate([](const BenchState& s) { return s.t_s >= 137.3 ? -0.02 : 0.0; });
}
template <int kCentihertz>
Injection Tone(const SyntheticBench&) {
  return Rate([](const BenchState& s) {
    return 0.02 * std::sin(2.0 * kPi * 0.01 * kCentihertz * s.t_s + 50.0 * kRad);
  });
}

// --- Effects on the angle, and lags.

template <int kPpm>
Injection ClockDrift(const SyntheticBench&) {
  return {{}, {}, [](double t_s) { return t_s * (1.0 + 1e-6 * kPpm); }};
}
// tau dw'/dt = w - w', by the exact step for a rate that is constant for a millisecond.
Injection Lag(const SyntheticBench& bench) {
  return Rate([&bench, lagged = 0.0, t_s = 0.0](const BenchState& s) mutable {
    constexpr double kTau_s = 0.015, kStep_s = 1e-3;
    for (; t_s < s.t_s - 0.5 * kStep_s; t_s += kStep_s)
      lagged += (Wz(bench.At(t_s + 0.5 * kStep_s)) - lagged) * -std::expm1(-kStep_s / kTau_s);
    return bench.sensor().m_row[2] * (lagged - Wz(s));
  });
}
Injection Worm(const SyntheticBench&) {
  return Angle([](const BenchState& s) { return 0.008 * std::sin(40.0 * Inner(s) + 0.7); });
}
Injection WormTwice(const SyntheticBench&) {
  return Angle([](const BenchState& s) { return 0.008 * std::sin(80.0 * Inner(s) - 1.1); });
}
Injection Eccentricity1(const SyntheticBench&) {
  return Angle([](const BenchState& s) { return 0.02 * std::sin(Inner(s) - 0.4); });
}
Injection Eccentricity2(const SyntheticBench&) {
  return Angle([](const BenchState& s) { return 0.02 * std::sin(2.0 * Inner(s) + 2.0); });
}
Injection Ripple(const SyntheticBench&) {
  return Angle([](const BenchState& s) { return 0.008 * std::sin(17.0 * Inner(s) + 1.0); });
}
// The reference is driven by a pin in a slot: it stands until the slot's other side has come.
Injection PlayBehindTable(const SyntheticBench& bench) {
  return Angle([&bench, driven = 0.0, t_s = 0.0](const BenchState& s) mutable {
    constexpr double kPlay_deg = 0.06, kStep_s = 1e-3;
    auto push = [&driven](double angle) {
      driven = std::clamp(driven, angle - kPlay_deg / 2.0, angle + kPlay_deg / 2.0);
    };
    for (; t_s < s.t_s; t_s += kStep_s) push(bench.motion().At(t_s).angle_deg[kInnerAxis]);
    push(s.table.angle_deg[kInnerAxis]);
    return s.table.angle_deg[kInnerAxis] - driven;
  });
}
// A lost line of the encoder, in the middle of a turn.
template <int kAt_s>
Injection AngleStep(const SyntheticBench&) {
  return Angle([](const BenchState& s) { return s.t_s >= kAt_s ? 0.1 : 0.0; });
}

// For what is told in deg or s of the bench: see the rows of a scaled gyro.
BenchSensor NominalScale() {
  BenchSensor sensor;
  sensor.m_row[2] = 1.0;
  return sensor;
}
// Turned back several times a second: where between two readings says how far the play is crossed.
Motion QuickSwings() {
  Motion motion;
  motion.Rest(10.0);
  for (const double rate : {10.0, 25.0, 40.0}) motion.ThereAndBack(kInnerAxis, 150.0, rate);
  for (int round = 0; round < 4; ++round) {
    for (const double hz : {0.8, 1.2, 1.6}) motion.Swing(kInnerAxis, 3.0, hz, 12).Rest(2.0);
  }
  return motion;
}
BenchSensor UpsideDown() {
  BenchSensor sensor;
  sensor.m_row[2] = -1.0;
  return sensor;
}
BenchSensor QuickWarmth() {
  BenchSensor sensor;
  sensor.temperature_period_s = 190.0;
  return sensor;
}

const std::vector<Row>& Rows() {
  static const std::vector<Row> rows = {
      {"bias.g_linear", "", GLinear, {{"k_x", 0.02}, {"k_y", -0.03}, {"k_z", 0.01}}},
      {"bias.g_squared", "", GSquared, {{"k_x", 0.02}, {"k_y", -0.01}}},
      {"bias.temperature_rate", "", TemperatureRate, {{"c", 0.2}}},
      {"bias.hysteresis", "", Hysteresis<0>, {{"c", 0.02}, {"r", 1.0}}},
      {"bias.hysteresis", "begun_before", Hysteresis<7>, {{"c", 0.02}, {"r", 1.0}}},
      {"bias.warm_up", "", WarmUp, {{"A", 0.1}, {"tau", 30.0}}},
      {"scale.g", "", ScaleG, {{"c_x", 4e-4}, {"c_y", -3e-4}, {"c_z", 5e-4}}},
      {"scale.temperature", "", ScaleTemperature, {{"c", 1e-4}}},
      {"scale.quadratic_odd", "", QuadraticOdd, {{"c", 2e-5}}},
      {"scale.cubic", "", Cubic, {{"c", 6e-7}}},
      {"scale.quadratic_even", "", QuadraticEven, {{"c", -1e-5}}},
      {"scale.asymmetry", "", Asymmetry, {{"c", 4e-4}}},
      {"bias.vibration", "felt", Vibration, {{"c", 4.0}}, ManySpeeds},
      {"bias.vibration", "resonance", Resonance, {{"A", 0.05}, {"f0", 12.7}, {"width", 2.4}}},
      {"bias.of(supply_v)", "", BiasOfSupply, {{"c", 0.2}}, EveryMotion, {}, true},
      {"scale.of(supply_v)", "", ScaleOfSupply, {{"c", 0.004}}, EveryMotion, {}, true},
      {"bias.earth_rate",
       "",
       EarthRate,
       {{"up", kEarth_deg_s[2]}, {"world_x", kEarth_deg_s[0]}, {"world_y", kEarth_deg_s[1]}}},
      {"bias.step", "", BiasStep, {{"b", -0.02}, {"t0", 137.3, 1.0}}},
      {"bias.tone", "", Tone<73>, {{"amplitude", 0.02}, {"phase", 50.0}, {"f", 0.73}}},
      // Periods of a few intervals: their mean over an interval is less than their height.
      {"bias.tone", "of_3_hz", Tone<319>, {{"amplitude", 0.02}, {"phase", 50.0}, {"f", 3.19}}},
      {"angle.latency", "", Latency, {{"tau", 0.012}}, EveryMotion, NominalScale()},
      {"bandwidth.first_order", "", Lag, {{"tau", 0.015}}, EveryMotion, NominalScale()},
      {"angle.clock_drift", "", ClockDrift<8>, {{"eps", 8.0}}, EveryMotion, NominalScale()},
      {"angle.worm_period",
       "",
       Worm,
       {{"amplitude_inner", 0.008}, {"phase_inner", 0.7 / kRad}, {"harmonic", 1.0, 1e-9}},
       EveryMotion,
       NominalScale()},
      {"angle.worm_period",
       "second_harmonic",
       WormTwice,
       {{"amplitude_inner", 0.008}, {"phase_inner", -1.1 / kRad}, {"harmonic", 2.0, 1e-9}},
       EveryMotion,
       NominalScale()},
      {"angle.eccentricity_1",
       "",
       Eccentricity1,
       {{"amplitude_inner", 0.02}, {"phase_inner", -0.4 / kRad}},
       EveryMotion,
       NominalScale()},
      {"angle.eccentricity_2",
       "",
       Eccentricity2,
       {{"amplitude_inner", 0.02}, {"phase_inner", 2.0 / kRad}},
       EveryMotion,
       NominalScale()},
      {"angle.ripple",
       "",
       Ripple,
       {{"amplitude_inner", 0.008}, {"phase_inner", 1.0 / kRad}, {"k", 17.0}},
       EveryMotion,
       NominalScale()},
      {"angle.backlash", "", PlayBehindTable, {{"b_inner", 0.06}}, EveryMotion, NominalScale()},
      {"angle.backlash",
       "in_quick_swings",
       PlayBehindTable,
       {{"b_inner", 0.06}},
       QuickSwings,
       NominalScale()},
      {"angle.step",
       "",
       AngleStep<58>,
       {{"b_inner", 0.1}, {"t0", 58.0, 0.2}},
       EveryMotion,
       NominalScale()},
      {"angle.latency", "of_a_scaled_gyro", Latency, {{"tau", 0.012}}, EveryMotion, {}, false},
      {"bandwidth.first_order", "of_a_scaled_gyro", Lag, {{"tau", 0.015}}, EveryMotion, {}, false},
      {"angle.clock_drift",
       "of_many_ms",
       ClockDrift<60>,
       {{"eps", 60.0}},
       EveryMotion,
       NominalScale(),
       false},
      {"bias.temperature_rate",
       "of_a_quick_swing",
       TemperatureRate,
       {{"c", 0.2}},
       EveryMotion,
       QuickWarmth(),
       false},
      {"angle.latency_of_run",
       "the_second",
       Latency,
       {{"tau", 0.012}, {"run", 2.0, 0.1}},
       EveryMotion,
       {},
       false,
       true},
      {"angle.latency", "upside_down", Latency, {{"tau", 0.012}}, EveryMotion, UpsideDown(), false},
      {"angle.backlash",
       "upside_down",
       PlayBehindTable,
       {{"b_inner", 0.06}},
       EveryMotion,
       UpsideDown(),
       false},
      {"scale.temperature",
       "upside_down",
       ScaleTemperature,
       {{"c", 1e-4}},
       EveryMotion,
       UpsideDown(),
       false},
      {"angle.step",
       "in_a_quiet_measurement",
       AngleStep<72>,
       {{"b_inner", 0.1}, {"t0", 72.0, 0.2}},
       EveryMotion,
       {},
       false},
  };
  return rows;
}

class EachEffect : public ::testing::TestWithParam<Row> {};

TEST_P(EachEffect, IsNamedAndItsNumbersAreWithinTheirInterval) {
  const Row& row = GetParam();
  const SyntheticBench bench(row.motion(), row.sensor);
  const calibration::Recording recording = bench.Measure(row.make(bench), 7, row.with_supply);
  calibration::Recording before = bench.Measure({}, 8, row.with_supply);
  before.info.power_on = "before";
  std::vector<const calibration::Recording*> inputs = {&recording};
  if (row.after_another_run) inputs.insert(inputs.begin(), &before);
  const ChannelTrace channel = TraceOf(inputs, 1);
  ASSERT_THAT(channel.effects, ::testing::SizeIs(1))
      << ::testing::PrintToString(NamesOf(channel)) << "\n"
      << channel.summary;
  const TracedEffect& effect = channel.effects[0];
  ASSERT_EQ(effect.id, row.id) << channel.summary;
  for (const Expected& expected : row.parameters)
    ExpectWithinItsInterval(effect.parameters, expected);
}

std::string NameOf(const ::testing::TestParamInfo<Row>& info) {
  std::string name = info.param.id;
  if (!info.param.note.empty()) name += "_" + info.param.note;
  std::ranges::replace_if(
      name, [](char c) { return std::isalnum(c) == 0; }, '_');
  return name;
}
INSTANTIATE_TEST_SUITE_P(Catalogue, EachEffect, ::testing::ValuesIn(Rows()), NameOf);

// An effect is in the catalogue when it has a row here: the promise of docs/contributing.md.
TEST(EveryEffect, OfTheCatalogueHasARowHere) {
  for (const calibration::Effect& effect : calibration::EffectCatalogue()) {
    const bool there = std::ranges::any_of(
        Rows(), [&](const Row& row) { return calibration::CatalogueName(row.id) == effect.id; });
    EXPECT_TRUE(there) << effect.id;
  }
}

// There is one of each that other rooms speak of, and it has the terms that they read.
TEST(SingleEffects, AreInTheCatalogueOnce) {
  using calibration::EffectDomain;
  using calibration::Search;
  EXPECT_EQ(calibration::GSensitivityEffect().terms.size(), 3u);
  EXPECT_TRUE(calibration::EarthRotationEffect().true_motion);
  for (const auto& [search, domain] : {std::pair{Search::kTime, EffectDomain::kRate},
                                       {Search::kTime, EffectDomain::kAngle},
                                       {Search::kFrequency, EffectDomain::kRateIntegral},
                                       {Search::kPeriods, EffectDomain::kAngle}}) {
    const auto count =
        std::ranges::count_if(calibration::EffectCatalogue(), [&](const calibration::Effect& one) {
          return one.search == search && one.domain == domain;
        });
    ASSERT_EQ(count, 1);
    EXPECT_EQ(calibration::ScannedEffect(search, domain).search, search);
  }
}

}  // namespace
}  // namespace gyrobench::testing
