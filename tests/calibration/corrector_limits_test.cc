// What the correction does beyond the calibration, without what it needs, and with what it was not
// made for.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include "base/error.h"
#include "calibration/artefact/corrector.h"
#include "tests/calibration/corrector_sample.h"

namespace gyrobench::calibration {
namespace {

using testing::Contains;
using testing::HasSubstr;

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

// A count is no rate, and where nothing says how many make one nothing is written as if it were.
TEST(Corrector, LeavesAnAxisEmptyWhoseCountsNothingTellsInDegreesPerSecond) {
  Calibration calibration = ThreeAxes();
  for (std::size_t c : {0U, 1U}) {
    ChannelModel& model = calibration.channels[c].model;
    model.units_per_deg_s = 1.0;
    model.m_row = {0.0, 0.0, 0.0};
    model.bias_deg_s = {300.0};
  }
  calibration.channels[2].model.m_row = {0.0, 0.0, 1.03};
  MeasurementInfo info = Info();
  const auto sample_at = [&](double t) {
    GyroSample sample = Sample(t, calibration);
    sample.xi[0] = sample.xi[1] = 300.0;
    return sample;
  };
  info.gyro_units_per_deg_s.reset();
  const Corrected out = Correct(calibration, info, sample_at);
  EXPECT_LT(LargestError(out.rates, {2}), 1e-6);
  EXPECT_TRUE(std::ranges::all_of(
      out.rates, [](const Vector3& rate) { return std::isnan(rate[0]) && std::isnan(rate[1]); }));
  EXPECT_EQ(out.report.channels[0].missing, static_cast<std::int64_t>(kSamples));
  EXPECT_THAT(out.report.remarks, Contains(HasSubstr("gyro x: left empty")));
  // A part of 1 count per deg/s is one, if somebody says so.
  info.gyro_units_per_deg_s = 1.0;
  calibration.channels[2].model.units_per_deg_s = 1.0;
  const Corrected told = Correct(calibration, info, sample_at);
  EXPECT_FALSE(std::isnan(told.rates[10][0]));
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

}  // namespace
}  // namespace gyrobench::calibration
