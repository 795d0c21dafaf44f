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

#include "base/error.h"

namespace gyrobench::calibration {
namespace {

using testing::Contains;
using testing::HasSubstr;

constexpr double kUnits = 131.0;  // LSB per deg/s
constexpr double kInterval_s = 0.01;
constexpr double kDuration_s = 60.0;

Vector3 TrueRate(double t) {
  return {12.0 * std::sin(0.5 * t), 25.0 * std::cos(0.31 * t), 40.0 * std::sin(0.2 * t + 1.0)};
}
// Slow enough that lines over 10 s follow it to 1e-4.
double Temperature(double t) { return 25.0 + 0.05 * t; }
Vector3 Gravity() { return {0.6, 0.0, 0.8}; }
double Supply(double t) { return 3.3 + 0.2 * std::sin(0.05 * t); }

MeasurementInfo Info() {
  MeasurementInfo info;
  info.gyro_present = info.accel_present = {true, true, true};
  info.temperature_present = true;
  info.gyro_units_per_deg_s = kUnits;
  info.covariates = {"motor_a", "supply_v"};
  return info;
}

Calibration ThreeAxes() {
  Calibration calibration;
  const std::array<Vector3, 3> m = {
      {{1.01, 0.02, -0.01}, {0.005, 0.98, 0.015}, {-0.02, 0.01, 1.03}}};
  for (std::size_t c = 0; c < 3; ++c) {
    ChannelCalibration channel;
    channel.model.axis = static_cast<SensorAxis>(c);
    channel.model.unit = "LSB";
    channel.model.units_per_deg_s = kUnits;
    channel.model.m_row = m[c];
    channel.model.reference_degC = 26.0;
    channel.model.bias_deg_s = {0.5 - 0.3 * static_cast<double>(c), 0.02, -0.001};
    channel.model.min_temperature_degC = 20.0;
    channel.model.max_temperature_degC = 30.0;
    channel.model.max_rate_deg_s = 45.0;
    calibration.channels.push_back(channel);
  }
  return calibration;
}

using Extra = std::function<double(std::size_t channel, double t, const Vector3& w)>;

GyroSample Sample(double t, const Calibration& calibration, const Extra& extra = {}) {
  GyroSample sample;
  sample.t_s = t;
  sample.temperature_degC = Temperature(t);
  sample.accel_g = Gravity();
  const Vector3 w = TrueRate(t);
  for (const ChannelCalibration& channel : calibration.channels) {
    const ChannelModel& model = channel.model;
    const auto c = static_cast<std::size_t>(model.axis);
    const double off = Temperature(t) - model.reference_degC;
    double rate = model.bias_deg_s[0] + model.bias_deg_s[1] * off + model.bias_deg_s[2] * off * off;
    for (std::size_t j = 0; j < 3; ++j) rate += model.m_row[j] * w[j];
    if (extra) rate += extra(c, t, w);
    sample.xi[c] = kUnits * rate;
  }
  return sample;
}

struct Corrected {
  std::vector<Vector3> rates;
  CorrectionReport report;
};

Corrected Correct(const Calibration& calibration, const MeasurementInfo& info,
                  const std::function<GyroSample(double t)>& sample_at) {
  Corrector corrector(calibration, info);
  Corrected out;
  Vector3 rate;
  for (int i = 0; i * kInterval_s < kDuration_s; ++i) {
    const double t = i * kInterval_s;
    const std::vector<double> covariates = {0.0, Supply(t)};
    corrector.Add(sample_at(t), covariates);
    while (corrector.Next(&rate)) out.rates.push_back(rate);
  }
  corrector.End();
  while (corrector.Next(&rate)) out.rates.push_back(rate);
  out.report = corrector.Report();
  return out;
}

double LargestError(const std::vector<Vector3>& rates, std::vector<std::size_t> axes = {0, 1, 2}) {
  double largest = 0.0;
  for (std::size_t i = 0; i < rates.size(); ++i) {
    const Vector3 w = TrueRate(static_cast<double>(i) * kInterval_s);
    for (const std::size_t c : axes) {
      const double error = std::fabs(rates[i][c] - w[c]);
      largest = std::isnan(error) ? 1e9 : std::max(largest, error);
    }
  }
  return largest;
}

ModelTerm Term(const std::string& id, std::vector<double> coefficients,
               std::vector<double> nonlinear = {}) {
  ModelTerm term;
  term.id = id;
  term.coefficients = std::move(coefficients);
  term.nonlinear = std::move(nonlinear);
  term.reference_degC = 26.0;
  return term;
}

constexpr std::size_t kSamples = 6000;

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
ModelTerm Empirical() {
  ModelTerm term = Term("empirical(supply_v)", {0.3, 0.1});
  term.origin = EffectOrigin::kEmpirical;
  term.factors = {"supply_v"};
  term.knots = {3.0, 3.5};
  return term;
}
ModelTerm OfSupply(const std::string& id, double coefficient) {
  ModelTerm term = Term(id, {coefficient});
  term.covariate = "supply_v";
  term.covariate_mean = 3.3;
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

TEST(Corrector, OfOneAxisNeedsThatRowAlone) {
  Calibration calibration = ThreeAxes();
  calibration.channels.erase(calibration.channels.begin(), calibration.channels.begin() + 2);
  calibration.channels[0].model.m_row = {0.0, 0.0, 1.03};
  MeasurementInfo info = Info();
  info.gyro_present = {false, false, true};
  const Corrected out =
      Correct(calibration, info, [&](double t) { return Sample(t, calibration); });
  EXPECT_LT(LargestError(out.rates, {2}), 1e-6);
  EXPECT_TRUE(std::isnan(out.rates[10][0]));
}

TEST(Corrector, GivesNothingForNothingAndCountsIt) {
  const Calibration calibration = ThreeAxes();
  const Corrected out = Correct(calibration, Info(), [&](double t) {
    GyroSample sample = Sample(t, calibration);
    if (t > 10.0 && t < 10.1) sample.xi[1] = kMissing;
    if (t > 20.0 && t < 20.1) sample.xi = {kMissing, kMissing, kMissing};
    return sample;
  });
  ASSERT_EQ(out.rates.size(), kSamples);
  EXPECT_TRUE(std::isnan(out.rates[1005][1]));
  // The others go on, with the rate that the missing one had last.
  EXPECT_NEAR(out.rates[1005][0], TrueRate(10.05)[0], 0.05);
  EXPECT_TRUE(std::isnan(out.rates[2005][0]));
  EXPECT_EQ(out.report.channels[0].missing, 9);
  EXPECT_EQ(out.report.channels[1].missing, 18);
}

TEST(Corrector, CountsWhatLiesBeyondTheCalibrationAndByHowMuch) {
  Calibration calibration = ThreeAxes();
  calibration.channels[2].model.max_rate_deg_s = 20.0;
  calibration.channels[0].model.max_temperature_degC = 26.0;
  calibration.channels[0].model.bias_deg_s = {0.5};
  const Corrected out = Correct(calibration, Info(), [&](double t) {
    GyroSample sample = Sample(t, ThreeAxes());
    sample.xi[0] -=
        kUnits * (0.02 * (Temperature(t) - 26.0) - 0.001 * std::pow(Temperature(t) - 26.0, 2));
    return sample;
  });
  EXPECT_LT(LargestError(out.rates), 1e-6);
  const std::vector<ChannelCorrection>& channels = out.report.channels;
  EXPECT_GT(channels[2].beyond_rate, 1000);
  EXPECT_NEAR(channels[2].largest_rate_deg_s, 40.0, 0.1);
  EXPECT_EQ(channels[1].beyond_rate, 0);
  EXPECT_NEAR(static_cast<double>(channels[0].beyond_temperature), 3000, 20);
  EXPECT_NEAR(channels[0].highest_degC, 28.0, 0.01);
  EXPECT_EQ(channels[1].beyond_temperature, 0);
  EXPECT_GT(out.report.outside, channels[0].beyond_temperature);
  EXPECT_LT(out.report.outside, channels[0].beyond_temperature + channels[2].beyond_rate);
}

// w - 1e-4 w^3 turns back at 58 deg/s: a rate of 100 has no solution in it, one of 70 a false one.
TEST(Corrector, HoldsEffectsBeyondTheRatesOfTheCalibrationAtTheirValueAtTheEdge) {
  Calibration calibration = ThreeAxes();
  for (ChannelCalibration& channel : calibration.channels) channel.model.m_row = {};
  for (std::size_t c = 0; c < 3; ++c) calibration.channels[c].model.m_row[c] = 1.0;
  ChannelModel& x = calibration.channels[0].model;
  x.terms = {Term("scale.cubic", {-1e-4}), Term("scale.temperature", {1e-3})};
  x.max_rate_deg_s = 40.0;
  for (const double rate_deg_s : {-200.0, -41.0, -20.0, 20.0, 39.0, 41.0, 100.0, 1000.0}) {
    const double held = std::clamp(rate_deg_s, -40.0, 40.0);
    const Corrected out = Correct(calibration, Info(), [&](double t) {
      GyroSample sample = Sample(t, calibration);
      const double scale = 1.0 + 1e-3 * (Temperature(t) - 26.0);
      sample.xi[0] += kUnits * (scale * rate_deg_s - TrueRate(t)[0] - 1e-4 * std::pow(held, 3));
      return sample;
    });
    ASSERT_NEAR(out.rates[3000][0], rate_deg_s, 1e-4);
    ASSERT_LT(LargestError(out.rates, {1, 2}), 1e-6) << rate_deg_s;
    EXPECT_EQ(out.report.channels[0].unsolved, 0);
  }
}

TEST(Corrector, HoldsBiasAndEffectsBeyondTheTemperaturesAtTheirValueAtTheEdge) {
  Calibration calibration = ThreeAxes();
  calibration.channels[1].model.min_temperature_degC = 26.0;
  calibration.channels[1].model.max_temperature_degC = 27.0;
  calibration.channels[1].model.terms = {Term("scale.temperature", {0.02})};
  const Corrected out = Correct(calibration, Info(), [&](double t) {
    GyroSample sample = Sample(t, calibration);
    const double off = Temperature(t) - 26.0, held = std::clamp(off, 0.0, 1.0);
    const double bias = 0.02 * (held - off) - 0.001 * (held * held - off * off);
    sample.xi[1] += kUnits * (bias + 0.02 * held * TrueRate(t)[1]);
    return sample;
  });
  EXPECT_LT(LargestError(out.rates), 1e-3);
}

TEST(Corrector, WithoutAnAccelerometerLeavesGravityOutAndSaysSo) {
  Calibration calibration = ThreeAxes();
  calibration.channels[0].model.terms = {Term("bias.g_linear", {0.1, 0.1, 0.1})};
  MeasurementInfo info = Info();
  info.accel_present = {};
  const Corrected out =
      Correct(calibration, info, [&](double t) { return Sample(t, calibration); });
  EXPECT_LT(LargestError(out.rates), 1e-6);
  EXPECT_THAT(out.report.remarks, Contains(HasSubstr("bias.g_linear is not applied")));
}

TEST(Corrector, WithoutAColumnLeavesItsEffectsOutAndNamesIt) {
  Calibration calibration = ThreeAxes();
  calibration.channels[0].model.terms = {OfSupply("bias.of", 0.5), Empirical()};
  MeasurementInfo info = Info();
  info.covariates.clear();
  const Corrected out =
      Correct(calibration, info, [&](double t) { return Sample(t, calibration); });
  EXPECT_THAT(out.report.remarks, Contains(HasSubstr("supply_v")));
  EXPECT_LT(LargestError(out.rates), 1e-6);
}

TEST(Corrector, WithoutATemperatureTakesTheBiasAtTheReferenceAndSaysSo) {
  const Calibration calibration = ThreeAxes();
  MeasurementInfo info = Info();
  info.temperature_present = false;
  const Corrected out = Correct(calibration, info, [&](double t) {
    GyroSample sample = Sample(t, calibration);
    sample.temperature_degC = kMissing;
    return sample;
  });
  EXPECT_THAT(out.report.remarks, Contains(HasSubstr("no temperature")));
  EXPECT_LT(LargestError(out.rates), 0.1);  // b(T) over the range
}

// The calibration's own range is too wide for its cubic term: it folds at 18 deg/s.
TEST(Corrector, GivesNothingWhereTheModelHasNoSolutionAndLeavesTheOtherAxesAlone) {
  Calibration calibration = ThreeAxes();
  calibration.channels[2].model.terms = {Term("scale.cubic", {-1e-3})};
  calibration.channels[0].model.terms = {Term("scale.quadratic_odd", {1e-4})};
  const Corrected out = Correct(calibration, Info(), [&](double t) {
    return Sample(t, calibration, [](std::size_t c, double, const Vector3& w) {
      return c == 0 ? 1e-4 * w[0] * std::fabs(w[0]) : 0.0;
    });
  });
  EXPECT_GT(out.report.channels[2].unsolved, 0);
  EXPECT_EQ(out.report.channels[0].corrected, static_cast<std::int64_t>(kSamples));
  EXPECT_EQ(out.report.channels[1].corrected, static_cast<std::int64_t>(kSamples));
  const auto empty = std::count_if(out.rates.begin(), out.rates.end(),
                                   [](const Vector3& w) { return std::isnan(w[2]); });
  EXPECT_EQ(empty, out.report.channels[2].unsolved);
  for (std::size_t i = 0; i < out.rates.size(); ++i) {
    if (!std::isnan(out.rates[i][2])) continue;
    const Vector3 w = TrueRate(static_cast<double>(i) * kInterval_s);
    // What is left is 1 % and 1.5 % of the effects that the empty axis went without.
    ASSERT_NEAR(out.rates[i][0], w[0], 1e-6);
    ASSERT_NEAR(out.rates[i][1], w[1], 1e-6);
  }
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

std::string RefusalOf(const Calibration& calibration, const MeasurementInfo& info,
                      const CorrectorOptions& options = {}) {
  try {
    Corrector corrector(calibration, info, options);
  } catch (const DataError& error) {
    return error.what();
  }
  return "";
}

TEST(Corrector, RefusesDataOfAnotherUnitRangeSensorOrAxis) {
  Calibration calibration = ThreeAxes();
  calibration.sensor = "MPU-17";
  MeasurementInfo info = Info();
  EXPECT_EQ(RefusalOf(calibration, info), "");
  info.gyro_unit = RateUnit::kDegPerSecond;
  EXPECT_THAT(RefusalOf(calibration, info), HasSubstr("expects LSB"));
  info = Info();
  info.gyro_units_per_deg_s = 65.5;
  EXPECT_THAT(RefusalOf(calibration, info), HasSubstr("65.5"));
  info = Info();
  info.sensor = "MPU-18";
  EXPECT_THAT(RefusalOf(calibration, info), HasSubstr("MPU-18"));
  EXPECT_EQ(RefusalOf(calibration, info, {.any_sensor = true}), "");
  calibration.channels.resize(1);
  info = Info();
  info.gyro_present = {false, false, true};
  EXPECT_THAT(RefusalOf(calibration, info), HasSubstr("none of its axes"));
}

TEST(Corrector, TakesTheNominalScaleOfAnAxisThatWasNeverTurnedAndSaysSo) {
  Calibration calibration = ThreeAxes();
  calibration.channels[0].model.m_row = {0.0, 0.0, 0.0};
  Calibration as_if = ThreeAxes();
  as_if.channels[0].model.m_row = {1.0, 0.0, 0.0};
  const Corrected out = Correct(calibration, Info(), [&](double t) { return Sample(t, as_if); });
  EXPECT_LT(LargestError(out.rates), 1e-6);
  EXPECT_THAT(out.report.remarks, Contains(HasSubstr("never turned")));
}

TEST(Corrector, RefusesAMatrixWithoutAnInverse) {
  Calibration calibration = ThreeAxes();
  calibration.channels[1].model.m_row = calibration.channels[0].model.m_row;
  EXPECT_THAT(RefusalOf(calibration, Info()), HasSubstr("no inverse"));
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
