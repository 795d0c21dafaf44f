// Odd, poor and damaged measurements: a partial answer with a remark, never a crash or an invented
// number.
#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <limits>
#include <random>

#include "base/error.h"
#include "calibration/estimators/analyzer.h"
#include "tests/calibration/passed_on.h"
#include "tests/calibration/simulated_run.h"

namespace gyrobench::testing {
namespace {

using calibration::AnalysisResult;
using calibration::Analyzer;

bool Says(const std::vector<std::string>& remarks, const std::string& word) {
  for (const std::string& remark : remarks) {
    if (remark.find(word) != std::string::npos) return true;
  }
  return false;
}

std::int64_t Count(const AnalysisResult& result, const std::string& kind) {
  std::int64_t count = 0;
  for (const Defect& defect : result.defects) {
    if (defect.kind == kind) count += defect.count;
  }
  return count;
}

void ExpectFinite(const AnalysisResult& result) {
  for (const auto& scale : result.scale) {
    EXPECT_TRUE(std::isfinite(scale.alpha) && std::isfinite(scale.alpha_std_error));
    EXPECT_TRUE(std::isfinite(scale.bias) && std::isfinite(scale.bias_std_error));
    EXPECT_GT(scale.alpha_std_error, 0);
  }
  for (const auto& bias : result.bias) {
    for (const double c : bias.coefficients) EXPECT_TRUE(std::isfinite(c));
    for (const double e : bias.std_errors) EXPECT_TRUE(std::isfinite(e));
  }
}

// Stands between the simulation and the analyzer and spoils what passes.
class SpoiledOnItsWay final : public PassedOn {
 public:
  using PassedOn::PassedOn;
  std::function<void(MeasurementInfo*)> info = [](MeasurementInfo*) {};
  std::function<bool(GyroSample*)> gyro = [](GyroSample*) { return true; };
  std::function<bool(AngleSample*)> angle = [](AngleSample*) { return true; };

  void OnInfo(const MeasurementInfo& value) override {
    MeasurementInfo mine = value;
    info(&mine);
    PassedOn::OnInfo(mine);
  }
  void OnGyro(const GyroSample& value) override {
    GyroSample mine = value;
    if (gyro(&mine)) PassedOn::OnGyro(mine);
  }
  void OnAngle(const AngleSample& value) override {
    AngleSample mine = value;
    if (angle(&mine)) PassedOn::OnAngle(mine);
  }
};

struct Spoiled {
  Analyzer analyzer;
  SpoiledOnItsWay spoiler{analyzer};
  AnalysisResult Run(const TurnSchedule& schedule = {}, const SimulatedSensor& sensor = {}) {
    SimulateTurns(schedule, sensor, 1, &spoiler);
    AnalysisResult result = analyzer.Result();
    ExpectFinite(result);
    return result;
  }
};

TEST(BadMeasurement, NothingAtAllIsAnErrorThatSaysSo) {
  Analyzer analyzer;
  MeasurementInfo info;
  info.source = "empty.csv";
  info.gyro_present = {true, true, true};
  analyzer.OnInfo(info);
  try {
    analyzer.Result();
    FAIL() << "expected DataError";
  } catch (const DataError& error) {
    EXPECT_NE(std::string(error.what()).find("empty.csv"), std::string::npos);
  }
}

TEST(BadMeasurement, NothingButNotANumberIsAnError) {
  Analyzer analyzer;
  MeasurementInfo info;
  info.gyro_present = {true, false, true};
  analyzer.OnInfo(info);
  for (int i = 0; i < 1000; ++i) {
    GyroSample sample;
    sample.t_s = 0.01 * i;
    analyzer.OnGyro(sample);
  }
  EXPECT_THROW(analyzer.Result(), DataError);
}

TEST(BadMeasurement, OneSampleIsAnErrorOrAnEmptyResultButNoCrash) {
  Analyzer analyzer;
  MeasurementInfo info;
  info.gyro_present = {true, true, true};
  analyzer.OnInfo(info);
  GyroSample sample;
  sample.xi = {1, 2, 3};
  analyzer.OnGyro(sample);
  EXPECT_THROW(analyzer.Result(), DataError);
  sample.t_s = 0.01;
  analyzer.OnGyro(sample);
  EXPECT_TRUE(analyzer.Result().bias.empty());
}

TEST(BadMeasurement, AChannelThatIsNeverANumberDoesNotSpoilTheOther) {
  Spoiled spoiled;
  spoiled.spoiler.info = [](MeasurementInfo* info) { info->gyro_present = {true, false, true}; };
  const AnalysisResult result = spoiled.Run();
  ASSERT_EQ(result.scale.size(), 1u);
  EXPECT_EQ(result.scale[0].axis, SensorAxis::kZ);
  EXPECT_NEAR(result.scale[0].alpha, SimulatedSensor{}.alpha(),
              5 * result.scale[0].alpha_std_error);
  EXPECT_TRUE(Says(result.remarks, "gyro x: no usable sample"));
  EXPECT_EQ(Count(result, "not_a_number"), result.samples);
}

TEST(BadMeasurement, AReferenceThatDoesNotMoveGivesABiasAndARemark) {
  Spoiled spoiled;
  spoiled.spoiler.angle = [](AngleSample* sample) {
    sample->angle_deg = 12.0;
    return true;
  };
  TurnSchedule still;
  still.turns = 1;
  still.angle_deg = 1e-3;
  still.rest_s = 30;
  const AnalysisResult result = spoiled.Run(still);
  EXPECT_TRUE(result.scale.empty());
  EXPECT_TRUE(Says(result.remarks, "the reference moved by 0 deg"));
  ASSERT_EQ(result.bias.size(), 1u);
  EXPECT_NEAR(result.bias[0].coefficients[0], 26.2, 0.5);
}

TEST(BadMeasurement, AReferenceThatIsNeverThereGivesARemark) {
  Spoiled spoiled;
  spoiled.spoiler.angle = [](AngleSample*) { return false; };
  const AnalysisResult result = spoiled.Run();
  EXPECT_TRUE(result.scale.empty());
  EXPECT_TRUE(result.bias.empty());
  EXPECT_TRUE(Says(result.remarks, "no usable reading"));
}

TEST(BadMeasurement, AGyroThatDoesNotFollowTheTableIsNotCalibrated) {
  Spoiled spoiled;
  spoiled.spoiler.gyro = [](GyroSample* sample) {
    static std::mt19937 random(1);
    sample->xi[2] = std::round(std::normal_distribution<double>(20, 5)(random));
    return true;
  };
  const AnalysisResult result = spoiled.Run();
  EXPECT_TRUE(result.scale.empty());
  EXPECT_TRUE(Says(result.remarks, "does not follow"));
}

// Each turn in which something is wrong is left out; the others give the answer.
TEST(BadMeasurement, GapsNotANumberSaturationAndWildReadingsCostTurnsButNotTheAnswer) {
  Spoiled spoiled;
  const TurnSchedule schedule;
  auto in_turn = [&](double t, int turn) {
    const double begin = schedule.rest_s + turn * (schedule.rest_s + schedule.TurnTime());
    return t > begin + 0.1 && t < begin + 0.3;
  };
  spoiled.spoiler.gyro = [&](GyroSample* sample) {
    if (in_turn(sample->t_s, 5)) return false;
    if (in_turn(sample->t_s, 10)) sample->xi[2] = kMissing;
    if (in_turn(sample->t_s, 15)) sample->xi[2] = 32767;
    if (in_turn(sample->t_s, 20)) sample->xi[2] = 555;
    return true;
  };
  spoiled.spoiler.angle = [&](AngleSample* sample) {
    if (std::fabs(sample->t_s - 51.0) < 0.01) sample->angle_deg = 1e4;
    return true;
  };
  const AnalysisResult result = spoiled.Run();
  EXPECT_EQ(Count(result, "gap"), 1);
  EXPECT_GT(Count(result, "not_a_number"), 30);
  EXPECT_GT(Count(result, "saturation"), 30);
  EXPECT_EQ(Count(result, "reference_outlier"), 1);
  ASSERT_EQ(result.scale.size(), 1u);
  EXPECT_LE(result.scale[0].turns, 38);
  EXPECT_GE(result.scale[0].turns, 36);
}

TEST(BadMeasurement, AFrozenSensorIsNotTakenForAVeryQuietOne) {
  Spoiled spoiled;
  spoiled.spoiler.info = [](MeasurementInfo* info) { info->gyro_present = {true, true, true}; };
  spoiled.spoiler.gyro = [](GyroSample* sample) {
    static std::mt19937 random(1);
    std::normal_distribution<double> noise(20, 5);
    for (const std::size_t c : {0u, 1u}) sample->xi[c] = std::round(noise(random));
    if (sample->t_s > 50 && sample->t_s < 60) sample->xi = {9, 9, 9};
    return true;
  };
  const AnalysisResult result = spoiled.Run();
  EXPECT_NEAR(static_cast<double>(Count(result, "frozen")), 2000, 2);
  ASSERT_EQ(result.scale.size(), 1u);
  EXPECT_NEAR(result.scale[0].alpha, SimulatedSensor{}.alpha(),
              5 * result.scale[0].alpha_std_error);
  ASSERT_EQ(result.bias.size(), 3u);
  EXPECT_NEAR(result.bias[0].coefficients[0], 20, 0.5);
}

TEST(BadMeasurement, ConstantTemperatureLeavesOneNumberAndARemark) {
  Analyzer analyzer;
  WarmUp constant;
  constant.duration_s = 120;
  constant.start_degC = constant.end_degC = 25;
  SimulateWarmUp(constant, {}, 1, &analyzer);
  const AnalysisResult result = analyzer.Result();
  ASSERT_EQ(result.bias.size(), 1u);
  EXPECT_EQ(result.bias[0].coefficients.size(), 1u);
  EXPECT_TRUE(Says(result.bias[0].remarks, "temperature varied by"));
  EXPECT_TRUE(Says(result.remarks, "no reference"));
}

TEST(BadMeasurement, NoNominalSensitivityLeavesOutWhatNeedsIt) {
  Spoiled spoiled;
  spoiled.spoiler.info = [](MeasurementInfo* info) { info->gyro_units_per_deg_s.reset(); };
  const AnalysisResult result = spoiled.Run();
  ASSERT_EQ(result.scale.size(), 1u);
  EXPECT_NEAR(result.scale[0].alpha, SimulatedSensor{}.alpha(),
              5 * result.scale[0].alpha_std_error);
  EXPECT_TRUE(std::isnan(result.scale[0].scale_error));
}

TEST(BadMeasurement, ASensorThatIsPerfectlyQuietDoesNotDivideByZero) {
  SimulatedSensor quiet;
  quiet.n = quiet.k = quiet.reading_noise_deg = 0;
  quiet.stop_half_width_deg = 1e-9;
  quiet.stop_accuracy_known = false;
  Analyzer analyzer;
  SimulateTurns({}, quiet, 1, &analyzer);
  const AnalysisResult result = analyzer.Result();
  ASSERT_EQ(result.scale.size(), 1u);
  EXPECT_NEAR(result.scale[0].alpha / quiet.alpha(), 1.0, 1e-3);
}

TEST(BadMeasurement, HandlingWithoutAReferenceIsNotTakenForBias) {
  Analyzer analyzer;
  MeasurementInfo info;
  info.gyro_unit = RateUnit::kRadPerSecond;
  info.gyro_present = {true, false, false};
  info.accel_present = {true, true, true};
  analyzer.OnInfo(info);
  std::mt19937 random(1);
  std::normal_distribution<double> normal;
  double angle = 0;
  for (int i = 0; i < 12000; ++i) {
    GyroSample sample;
    sample.t_s = 0.01 * i;
    // Every 10 s, 2 s of being turned over by 90 deg about x.
    const double phase = std::fmod(sample.t_s, 10.0);
    const double rate = phase > 8 ? 45.0 * (1 - std::cos((phase - 8) * 3.14159265358979)) : 0.0;
    angle += rate * 0.01;
    sample.xi[0] = (0.7 + rate + 0.05 * normal(random)) * 3.14159265358979 / 180;
    sample.accel_g = {0.003 * normal(random), std::sin(angle / 57.29578) + 0.003 * normal(random),
                      std::cos(angle / 57.29578)};
    analyzer.OnGyro(sample);
  }
  const AnalysisResult result = analyzer.Result();
  ASSERT_EQ(result.bias.size(), 1u);
  EXPECT_EQ(result.bias[0].unit, "deg/s");
  EXPECT_NEAR(result.bias[0].coefficients[0], 0.7, 0.01);
  EXPECT_NEAR(result.bias[0].duration_s, 12 * 7.0, 8.0);
}

// Whatever comes, in whatever order: no crash, no number that is not one.
TEST(BadMeasurement, RandomEventsNeverCrashNorMakeUpNumbers) {
  for (std::uint32_t seed = 1; seed <= 60; ++seed) {
    std::mt19937 random(seed);
    std::uniform_real_distribution<double> uniform(0.0, 1.0);
    auto odd = [&](double usual) {
      const double kind = uniform(random);
      if (kind < 0.02) return kMissing;
      if (kind < 0.03) return std::numeric_limits<double>::infinity();
      return kind < 0.05 ? 1e6 * (uniform(random) - 0.5) : usual;
    };
    MeasurementInfo info;
    info.gyro_unit = static_cast<RateUnit>(seed % 3);
    info.reference = static_cast<ReferenceKind>(seed % 4);
    info.stand_axis_present = {seed % 2 == 0, true, seed % 5 == 0};
    info.gyro_present = {true, seed % 2 == 0, seed % 3 == 0};
    info.accel_present = {seed % 7 == 0, false, false};
    if (seed % 5 == 0) info.site_latitude_deg = 50;
    if (seed % 6 == 0) info.stop_accuracy_deg = 0.025;
    Analyzer analyzer;
    analyzer.OnInfo(info);
    double t = 0;
    for (int i = 0; i < 4000; ++i) {
      t += uniform(random) < 0.01 ? 3 * uniform(random) - 0.5 : 0.01;
      const double angle = 30 * std::sin(0.3 * t);
      const double event = uniform(random);
      if (event < 0.5) {
        GyroSample sample;
        sample.t_s = odd(t);
        if (std::fabs(sample.t_s) > 1e4) sample.t_s = t;
        for (double& xi : sample.xi) xi = odd(9 * std::cos(0.3 * t) + uniform(random));
        sample.accel_g = {odd(0), odd(0), odd(1)};
        sample.temperature_degC = odd(20 + 0.1 * t);
        analyzer.OnGyro(sample);
      } else if (event < 0.8) {
        analyzer.OnAngle({odd(t), static_cast<int>(random() % 5) - 1, odd(angle)});
      } else if (event < 0.99) {
        const double half = 0.5 * angle / 57.29578;
        analyzer.OnOrientation(
            {odd(t), {odd(std::cos(half)), odd(std::sin(half)), odd(0), odd(0)}});
      } else {
        analyzer.OnTickPair({odd(t), odd(t)});
      }
    }
    try {
      ExpectFinite(analyzer.Result());
    } catch (const DataError& error) {
      EXPECT_GT(std::string(error.what()).size(), 20u);
    }
  }
}

}  // namespace
}  // namespace gyrobench::testing
