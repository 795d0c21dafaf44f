#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <nlohmann/json.hpp>
#include <numbers>
#include <random>
#include <sstream>

#include "base/error.h"
#include "base/geometry.h"
#include "tests/export/export_sample.h"

namespace gyrobench::exporting {
namespace {

using calibration::Calibration;
using nlohmann::json;
using testing::Contains;
using testing::HasSubstr;

// The value of "key: value  # comment"; NaN where there is no such line.
double Entry(const std::string& yaml, const std::string& key) {
  std::istringstream lines(yaml);
  for (std::string line; std::getline(lines, line);)
    if (line.starts_with(key + ":")) return std::stod(line.substr(key.size() + 1));
  return kMissing;
}

TEST(Kalibr, HasTheLargestFiguresOfTheAxesInItsUnits) {
  const Exported exported = Write(ThreeAxes(), "kalibr");
  EXPECT_NEAR(Entry(exported.text, "gyroscope_noise_density"), 0.0037 * kRadPerDeg, 1e-12);
  EXPECT_NEAR(Entry(exported.text, "gyroscope_random_walk"), 2e-4 * kRadPerDeg, 1e-13);
  EXPECT_THAT(exported.notes, Contains(HasSubstr("misalignment")));
  EXPECT_TRUE(std::isnan(Entry(exported.text, "update_rate")));
}

// Kalibr's model, sampled as it documents: a noise of density / sqrt(dt) a sample, a step of
// walk x sqrt(dt). After a second, angle and bias must have moved as the calibration says.
TEST(Kalibr, SampledAsItDocumentsWalksAsTheCalibrationSays) {
  const std::string yaml = Write(ThreeAxes(), "kalibr").text;
  const double density = Entry(yaml, "gyroscope_noise_density");
  const double walk = Entry(yaml, "gyroscope_random_walk");
  constexpr int kTrials = 3000, kSamples = 100;
  constexpr double kInterval_s = 1.0 / kSamples;
  std::mt19937_64 random(5);
  std::normal_distribution<double> normal;
  double angle_squares = 0.0, bias_squares = 0.0;
  for (int trial = 0; trial < kTrials; ++trial) {
    double angle_rad = 0.0, bias_rad_s = 0.0;
    for (int i = 0; i < kSamples; ++i) {
      angle_rad += density / std::sqrt(kInterval_s) * normal(random) * kInterval_s;
      bias_rad_s += walk * std::sqrt(kInterval_s) * normal(random);
    }
    angle_squares += angle_rad * angle_rad;
    bias_squares += bias_rad_s * bias_rad_s;
  }
  // Five standard errors of a standard deviation from 3000 trials: 6.5 %.
  EXPECT_NEAR(kDegPerRad * std::sqrt(angle_squares / kTrials), 0.0037, 0.065 * 0.0037);
  EXPECT_NEAR(kDegPerRad * std::sqrt(bias_squares / kTrials), 2e-4, 0.065 * 2e-4);
}

TEST(Kalibr, WithoutNoiseIsRefusedAndWithoutAWalkLeavesThatOut) {
  Calibration calibration = ThreeAxes();
  for (auto& channel : calibration.channels) channel.noise.bias_random_walk_deg_s_sqrt_s = 0.0;
  const Exported exported = Write(calibration, "kalibr");
  EXPECT_TRUE(std::isnan(Entry(exported.text, "gyroscope_random_walk")));
  EXPECT_THAT(exported.notes, Contains(HasSubstr("gyroscope_random_walk is not written")));
  for (auto& channel : calibration.channels) channel.noise = {};
  try {
    Write(calibration, "kalibr");
    FAIL() << "no noise, and no refusal";
  } catch (const DataError& error) {
    EXPECT_THAT(error.what(), HasSubstr("cal.json: no noise"));
    EXPECT_THAT(error.what(), HasSubstr("gyrobench trace"));
  }
}

// The formula that the file states, from nothing but the file.
Vector3 ByFormula(const json& file, const State& state) {
  Vector3 w = {}, y = {};
  for (int round = 0; round < 30; ++round) {
    for (std::size_t c = 0; c < 3; ++c) {
      const json& axis = file["axes"][c];
      y[c] = state.xi[c] / axis["units_per_deg_s"].get<double>();
      if (!axis["calibrated"].get<bool>()) continue;
      const json& range = axis["valid_for"];
      const double t =
          std::fmin(std::fmax(state.temperature_degC, range["min_temperature_degC"].get<double>()),
                    range["max_temperature_degC"].get<double>());
      double power = 1.0;
      for (const json& coefficient : axis["bias"]["coefficients_deg_s"]) {
        y[c] -= coefficient.get<double>() * power;
        power *= t - axis["bias"]["reference_degC"].get<double>();
      }
      for (const json& effect : axis["effects"]) {
        EXPECT_EQ(effect["equation"], "c w (T - T0)");
        y[c] -= effect["coefficients"][0].get<double>() * w[c] *
                (t - effect["reference_degC"].get<double>());
      }
    }
    for (std::size_t c = 0; c < 3; ++c) {
      w[c] = 0.0;
      for (std::size_t d = 0; d < 3; ++d) w[c] += file["matrix"][c][d].get<double>() * y[d];
    }
  }
  return w;
}

TEST(Json, SaysWhichCountStandsForZero) {
  Calibration calibration = ThreeAxes();
  EXPECT_TRUE(json::parse(Write(calibration, "json").text)["lsb_zero"].is_null());
  const json before = json::parse(Write(calibration, "json").text)["example"];
  calibration.gyro_lsb_zero = 32768.0;
  const json file = json::parse(Write(calibration, "json").text);
  EXPECT_EQ(file["lsb_zero"], 32768.0);
  EXPECT_EQ(file["example"], before) << "xi has the zero off";
}

TEST(Json, HoldsAllThatItsFormulaNeeds) {
  Calibration calibration = ThreeAxes();
  for (auto& channel : calibration.channels)
    channel.model.terms = {CatalogueTerm("scale.temperature", {1e-3})};
  const Exported exported = Write(calibration, "json");
  EXPECT_TRUE(exported.notes.empty());
  const json file = json::parse(exported.text);
  for (const double temperature : {15.0, 20.0, 23.5, 30.0, 33.0}) {
    const std::vector<State> states = StatesAt(temperature);
    const std::vector<Vector3> expected = Corrected(calibration, states);
    for (std::size_t i = 0; i < states.size(); ++i) {
      const Vector3 w = ByFormula(file, states[i]);
      for (std::size_t c = 0; c < 3; ++c) ASSERT_NEAR(w[c], expected[i][c], 1e-9);
    }
  }
  const json& example = file["example"];
  const State state{example["xi"], example["temperature_degC"], 0.0};
  for (std::size_t c = 0; c < 3; ++c)
    EXPECT_NEAR(ByFormula(file, state)[c], example["rate_deg_s"][c].get<double>(), 1e-9);
}

TEST(Json, HoldsEveryEffectThatApplyTakesOffAndNoOther) {
  Calibration calibration = ThreeAxes();
  calibration::ModelTerm eccentricity = CatalogueTerm("angle.eccentricity_1", {0.01, 0.02});
  eccentricity.owner = calibration::EffectOwner::kReference;
  calibration.channels[0].model.terms = {CatalogueTerm("bias.hysteresis", {0.02}, {2.0}),
                                         eccentricity, CurveTerm("T", {22.0, 24.0}, {0.0, 0.1}),
                                         CatalogueTerm("bias.step", {0.1}, {30.0})};
  const Exported exported = Write(calibration, "json");
  const json effects = json::parse(exported.text)["axes"][0]["effects"];
  ASSERT_EQ(effects.size(), 2u);
  EXPECT_EQ(effects[0]["id"], "bias.hysteresis");
  EXPECT_EQ(effects[1]["knots"], json({22.0, 24.0}));
  EXPECT_THAT(exported.notes, Contains(HasSubstr("bias.step")));
}

TEST(Exports, OfDifferentUnitsOrWithoutAnInverseAreRefused) {
  for (const Format& format : Formats()) {
    Calibration units = ThreeAxes(), singular = ThreeAxes();
    units.channels[1].model.unit = "deg/s";
    EXPECT_THROW(Write(units, format.name), DataError) << format.name;
    singular.channels[1].model.m_row = singular.channels[0].model.m_row;
    EXPECT_THROW(Write(singular, format.name), DataError) << format.name;
  }
}

// A file with a worked example that has no answer would be worse than none.
TEST(Exports, WithoutASolutionInTheMidstOfTheRangeAreRefused) {
  Calibration calibration = ThreeAxes();
  calibration.channels[0].model.terms = {CatalogueTerm("scale.temperature", {5.0})};
  for (const char* format : {"c", "json"}) {
    try {
      Write(calibration, format);
      FAIL() << "no refusal";
    } catch (const DataError& error) {
      EXPECT_THAT(error.what(),
                  HasSubstr("gyro x: the effects of the calibration have no solution"));
    }
  }
}

TEST(Exports, SayWhereTheyComeFromAndForWhatTheyAreValid) {
  for (const Format& format : Formats()) {
    const std::string text = Flat(Write(ThreeAxes(), format.name).text);
    for (const char* word :
         {"gyrobench 0.1.0", "cal.json", "aaaaaaaa", "MPU-17", "2026-11-21", "30", "45"}) {
      EXPECT_THAT(text, HasSubstr(word)) << format.name;
    }
  }
}

}  // namespace
}  // namespace gyrobench::exporting
