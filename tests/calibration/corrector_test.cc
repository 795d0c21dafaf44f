// Law: what the forward model does to a rate, the correction undoes. The forward model here is
// written out by hand; no basis of an effect is used.
#include "calibration/artefact/corrector.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <numbers>
#include <optional>

#include "tests/calibration/corrector_sample.h"

namespace gyrobench::calibration {
namespace {

using testing::Contains;
using testing::HasSubstr;

TEST(Corrector, UndoesMisalignmentScaleAndBiasOfThreeAxesTogether) {
  const Calibration calibration = ThreeAxes();
  const Corrected out =
      Correct(calibration, Info(), [&](double t) { return Sample(t, calibration); });
  ASSERT_EQ(out.rates.size(), kSamples);
  EXPECT_LT(LargestError(out.rates), 1e-6);
  EXPECT_TRUE(out.report.remarks.empty());
  EXPECT_EQ(out.report.channels.size(), 3u);
  EXPECT_EQ(out.report.channels[1].corrected, static_cast<std::int64_t>(kSamples));
}

struct Effects {
  const char* name;
  std::vector<ModelTerm> terms;  // of every channel
  Extra forward;
};

ModelTerm Composed() {
  ModelTerm term = Term("g_x*w", {4e-3});
  term.origin = EffectOrigin::kComposed;
  term.factors = {"g_x", "w_z"};
  term.offsets = {0.1, 2.0};
  return term;
}

class Undone : public testing::TestWithParam<Effects> {};

TEST_P(Undone, ByTheCorrection) {
  Calibration calibration = ThreeAxes();
  for (ChannelCalibration& channel : calibration.channels) channel.model.terms = GetParam().terms;
  const Corrected out = Correct(
      calibration, Info(), [&](double t) { return Sample(t, calibration, GetParam().forward); });
  // The effects are above 0.01 deg/s; what is left is the smoothing of the slow state.
  EXPECT_LT(LargestError(out.rates), 1e-3);
  EXPECT_TRUE(out.report.remarks.empty()) << out.report.remarks.front();
}

INSTANTIATE_TEST_SUITE_P(
    Effects, Undone,
    testing::Values(
        Effects{"g_sensitivity",
                {Term("bias.g_linear", {0.1, 0.2, -0.3})},
                [](std::size_t, double, const Vector3&) { return 0.1 * 0.6 - 0.3 * 0.8; }},
        Effects{"g_sensitivity_of_scale",
                {Term("scale.g", {1e-3, 0.0, 2e-3})},
                [](std::size_t c, double, const Vector3& w) {
                  return (1e-3 * 0.6 + 2e-3 * 0.8) * w[c];
                }},
        Effects{"temperature_of_scale",
                {Term("scale.temperature", {1e-3})},
                [](std::size_t c, double at, const Vector3& w) {
                  return 1e-3 * w[c] * (Temperature(at) - 26.0);
                }},
        Effects{
            "odd_nonlinearity",
            {Term("scale.quadratic_odd", {1e-4})},
            [](std::size_t c, double, const Vector3& w) { return 1e-4 * w[c] * std::fabs(w[c]); }},
        Effects{"cubic_and_asymmetry",
                {Term("scale.cubic", {1e-5}), Term("scale.asymmetry", {0.02})},
                [](std::size_t c, double, const Vector3& w) {
                  return 1e-5 * w[c] * w[c] * w[c] + 0.02 * std::fabs(w[c]);
                }},
        Effects{"temperature_rate",
                {Term("bias.temperature_rate", {0.8})},
                [](std::size_t, double, const Vector3&) { return 0.8 * 0.05; }},
        Effects{"warm_up",
                {Term("bias.warm_up", {0.2}, {40.0})},
                [](std::size_t, double at, const Vector3&) { return 0.2 * std::exp(-at / 40.0); }},
        Effects{"supply",
                {OfSupply("bias.of(supply_v)", 0.5), OfSupply("scale.of", 0.02)},
                [](std::size_t c, double at, const Vector3& w) {
                  return (0.5 + 0.02 * w[c]) * (Supply(at) - 3.3);
                }},
        Effects{"composed",
                {Composed()},
                [](std::size_t, double, const Vector3& w) {
                  return 4e-3 * (0.6 - 0.1) * (w[2] - 2.0);
                }},
        Effects{
            "empirical",
            {Empirical()},
            [](std::size_t, double at, const Vector3&) { return 0.3 - 0.4 * (Supply(at) - 3.0); }}),
    [](const auto& tested) { return std::string(tested.param.name); });

// Its sensitivity to gravity is along the axes of the table, where a tilted accelerometer is not.
TEST(Corrector, TakesGravityFromTheAccelerometerAsItIsCalibrated) {
  Calibration calibration = ThreeAxes();
  const Vector3 k = {0.1, 0.2, -0.3};
  for (ChannelCalibration& channel : calibration.channels)
    channel.model.terms = {Term("bias.g_linear", {k[0], k[1], k[2]})};
  AccelerometerCalibration& accelerometer = calibration.vector.emplace().accelerometer.emplace();
  accelerometer.m = {{{0.99, 0.1, 0.02}, {-0.1, 1.02, 0.0}, {0.01, 0.03, 1.0}}};
  accelerometer.offset_g = {0.05, -0.04, 0.03};
  const auto felt = [&](double t) {
    GyroSample sample = Sample(t, calibration, [&](std::size_t, double, const Vector3&) {
      return k[0] * Gravity()[0] + k[1] * Gravity()[1] + k[2] * Gravity()[2];
    });
    for (std::size_t i = 0; i < 3; ++i) {
      sample.accel_g[i] = accelerometer.offset_g[i];
      for (std::size_t j = 0; j < 3; ++j) sample.accel_g[i] += accelerometer.m[i][j] * Gravity()[j];
    }
    return sample;
  };
  EXPECT_LT(LargestError(Correct(calibration, Info(), felt).rates), 1e-3);
  accelerometer.m[0][0] = kMissing;  // not all of it known: as it is
  EXPECT_GT(LargestError(Correct(calibration, Info(), felt).rates), 1e-2);
}

TEST(Corrector, LeavesEffectsOfReferenceAndBenchAloneAndSaysSo) {
  Calibration calibration = ThreeAxes();
  ModelTerm eccentricity = Term("angle.eccentricity_1", {5.0, 5.0});
  eccentricity.owner = EffectOwner::kReference;
  calibration.channels[2].model.terms = {eccentricity};
  const Corrected out =
      Correct(calibration, Info(), [&](double t) { return Sample(t, calibration); });
  EXPECT_LT(LargestError(out.rates), 1e-6);
  EXPECT_THAT(out.report.remarks,
              Contains(HasSubstr("gyro z: angle.eccentricity_1 is not applied")));
}

TEST(Corrector, TakesRatesInRadiansAsTheTracerDoes) {
  Calibration calibration = ThreeAxes();
  for (ChannelCalibration& channel : calibration.channels) {
    channel.model.unit = "deg/s";
    channel.model.units_per_deg_s = 1.0;
  }
  MeasurementInfo info = Info();
  info.gyro_unit = RateUnit::kRadPerSecond;
  info.gyro_units_per_deg_s = std::numbers::pi / 180.0;
  const Corrected out = Correct(calibration, info, [&](double t) {
    GyroSample sample = Sample(t, calibration);
    for (double& xi : sample.xi) xi *= std::numbers::pi / 180.0 / kUnits;
    return sample;
  });
  EXPECT_LT(LargestError(out.rates), 1e-6);
}

// Counts about `zero` of a table that gives `given`, by a calibration of counts less `calibrated`
// whose bias holds `held` counts besides.
Corrected CountsAbout(double zero, std::optional<double> given, std::optional<double> calibrated,
                      double held) {
  Calibration calibration = ThreeAxes();
  const Calibration truth = calibration;
  for (ChannelCalibration& channel : calibration.channels)
    channel.model.bias_deg_s[0] += held / kUnits;
  calibration.gyro_lsb_zero = calibrated;
  MeasurementInfo info = Info();
  info.gyro_lsb_zero = given;
  return Correct(calibration, info, [&](double t) {
    GyroSample sample = Sample(t, truth);
    for (double& xi : sample.xi) xi += zero - given.value_or(0.0);
    return sample;
  });
}

// Whoever centred the counts, and whether somebody said so: the rate is the same.
TEST(Corrector, TakesTheZeroOffThatTheCalibrationWasMadeWith) {
  constexpr double kZero = 32768.0;
  struct Case {
    const char* what;
    double zero;
    std::optional<double> given, calibrated;
    double held;
    const char* remark;
  };
  for (const Case& one :
       {Case{"signed", 0.0, {}, 0.0, 0.0, ""}, Case{"given in both", kZero, kZero, kZero, 0.0, ""},
        Case{"recognised, and raw counts", kZero, {}, kZero, 0.0, "32768 is taken off those of"},
        Case{"given, and counts that were centred", 0.0, {}, kZero, 0.0, "centred already"},
        Case{"held in the bias", kZero, {}, 0.0, kZero, ""},
        Case{"held in the bias, and given", kZero, kZero, 0.0, kZero, "32768 is put back"},
        Case{"signed, and an unsigned logger", kZero, kZero, 0.0, 0.0, ""},
        Case{"another zero given", kZero, 32760.0, kZero, 0.0, "8 is taken off those of"},
        Case{"an older file, zero in its bias", kZero, {}, {}, kZero, ""}}) {
    SCOPED_TRACE(one.what);
    const Corrected out = CountsAbout(one.zero, one.given, one.calibrated, one.held);
    ASSERT_EQ(out.rates.size(), kSamples);
    EXPECT_LT(LargestError(out.rates), 1e-6);
    if (*one.remark == '\0') {
      EXPECT_TRUE(out.report.remarks.empty());
    } else {
      EXPECT_THAT(out.report.remarks, Contains(HasSubstr(one.remark)));
    }
  }
}

// What waits for the state around it is a few seconds of data, however long the table.
TEST(Corrector, HoldsBackSomeSecondsOfDataAndNoMore) {
  const Calibration calibration = ThreeAxes();
  Corrector corrector(calibration, Info());
  Vector3 rate;
  int in = 0, out = 0, most = 0;
  for (; in < 20000; ++in) {
    corrector.Add(Sample(in * kInterval_s, calibration), {});
    while (corrector.Next(&rate)) ++out;
    most = std::max(most, in - out);
  }
  EXPECT_LT(most * kInterval_s, 6.0);
}

}  // namespace
}  // namespace gyrobench::calibration
