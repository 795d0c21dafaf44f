// Law: the parameters, evaluated by the autopilots' documented formulas in the floats that they
// have, leave of the output what `gyrobench apply` leaves, but for the matrix M: M w.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <sstream>

#include "base/error.h"
#include "base/geometry.h"
#include "tests/export/export_sample.h"

namespace gyrobench::exporting {
namespace {

using calibration::Calibration;
using testing::Contains;
using testing::HasSubstr;

using Parameters = std::map<std::string, float>;

// Rows "1 1 NAME VALUE TYPE" between tabs.
Parameters ReadPx4(const std::string& text) {
  Parameters out;
  std::istringstream lines(text);
  for (std::string line; std::getline(lines, line);) {
    if (line.starts_with('#')) continue;
    EXPECT_EQ(std::count(line.begin(), line.end(), '\t'), 4) << line;
    std::istringstream fields(line);
    std::string vehicle, component, name, value;
    fields >> vehicle >> component >> name >> value;
    out[name] = std::stof(value);
  }
  return out;
}

// Rows "NAME,VALUE".
Parameters ReadArduPilot(const std::string& text) {
  Parameters out;
  std::istringstream lines(text);
  for (std::string line; std::getline(lines, line);) {
    if (line.starts_with('#')) continue;
    const std::size_t comma = line.find(',');
    EXPECT_EQ(line.find('e'), std::string::npos) << "an exponent: " << line;
    out[line.substr(0, comma)] = std::stof(line.substr(comma + 1));
  }
  return out;
}

float Held(float value, float low, float high) { return std::min(std::max(value, low), high); }

// docs/calibration.md, PX4: TemperatureCompensation.cpp, Gyroscope.hpp.
Vector3 ByPx4(const Parameters& p, const State& state) {
  Vector3 rate_deg_s;
  const bool thermal = p.contains("TC_G_ENABLE") && p.at("TC_G_ENABLE") == 1.0F;
  for (std::size_t c = 0; c < 3; ++c) {
    const std::string axis = std::to_string(c);
    float offset = 0.0F;
    if (thermal) {
      const float d =
          Held(static_cast<float>(state.temperature_degC), p.at("TC_G0_TMIN"), p.at("TC_G0_TMAX")) -
          p.at("TC_G0_TREF");
      offset = p.at("TC_G0_X0_" + axis) + p.at("TC_G0_X1_" + axis) * d +
               p.at("TC_G0_X2_" + axis) * d * d + p.at("TC_G0_X3_" + axis) * d * d * d;
    }
    const auto rate = static_cast<float>(state.xi[c] / kUnits / kDegPerRad);
    const std::string constant = std::string("CAL_GYRO0_") + "XYZ"[c] + "OFF";
    rate_deg_s[c] = kDegPerRad * static_cast<double>(rate - offset - p.at(constant));
  }
  return rate_deg_s;
}

// docs/calibration.md, ArduPilot: AP_InertialSensor_tempcal.cpp, AP_InertialSensor_Backend.cpp.
Vector3 ByArduPilot(const Parameters& p, const State& state) {
  Vector3 rate_deg_s;
  const bool thermal = p.contains("INS_TCAL1_ENABLE") && p.at("INS_TCAL1_ENABLE") == 1.0F;
  for (std::size_t c = 0; c < 3; ++c) {
    const std::string axis = std::string("_") + "XYZ"[c];
    const auto polynomial = [&](float temperature) {
      const float d = Held(temperature, p.at("INS_TCAL1_TMIN"), p.at("INS_TCAL1_TMAX")) - 35.0F;
      return (p.at("INS_TCAL1_GYR1" + axis) +
              (p.at("INS_TCAL1_GYR2" + axis) + p.at("INS_TCAL1_GYR3" + axis) * d) * d) *
             d * 1e-6F;
    };
    auto rate = static_cast<float>(state.xi[c] / kUnits / kDegPerRad);
    if (thermal) {
      rate -= polynomial(static_cast<float>(state.temperature_degC));
      rate += polynomial(p.at("INS_GYR1_CALTEMP"));
    }
    rate_deg_s[c] = kDegPerRad * static_cast<double>(rate - p.at("INS_GYROFFS" + axis));
  }
  return rate_deg_s;
}

struct Autopilot {
  const char* name;
  const char* format;
  Parameters (*read)(const std::string& text);
  Vector3 (*rate)(const Parameters& parameters, const State& state);
  const char* thermal;  // a parameter that only a calibration with temperatures has
};

class Autopilots : public testing::TestWithParam<Autopilot> {
 protected:
  // Largest difference to M w of the corrector [deg/s], of calibrated axes.
  double LargestDifference(const Calibration& calibration, const std::string& text) const {
    const Parameters parameters = GetParam().read(text);
    double largest = 0.0;
    for (const double temperature : {12.0, 20.0, 21.0, 23.7, 26.0, 29.0, 30.0, 41.0}) {
      const std::vector<State> states = StatesAt(temperature);
      const std::vector<Vector3> w = Corrected(calibration, states);
      for (std::size_t i = 0; i < states.size(); ++i) {
        const Vector3 rate = GetParam().rate(parameters, states[i]);
        for (const auto& channel : calibration.channels) {
          const Vector3& m = channel.model.m_row;
          const double left = m[0] * w[i][0] + m[1] * w[i][1] + m[2] * w[i][2];
          const auto c = static_cast<std::size_t>(channel.model.axis);
          largest = std::max(largest, std::fabs(rate[c] - left));
        }
      }
    }
    return largest;
  }
  Exported Written(const Calibration& calibration) const {
    return Write(calibration, GetParam().format);
  }
};

// Rounding of the floats.
constexpr double kFloat_deg_s = 3e-5;

TEST_P(Autopilots, GiveWhatApplyGivesWhereThereIsNoMatrix) {
  const Exported exported = Written(WithoutMatrix());
  EXPECT_LT(LargestDifference(WithoutMatrix(), exported.text), kFloat_deg_s);
  for (const std::string& note : exported.notes) {
    EXPECT_THAT(note, testing::Not(HasSubstr("misalignment")));
    EXPECT_THAT(Flat(exported.text), HasSubstr(note));
  }
}

TEST_P(Autopilots, LeaveTheMatrixAloneAndSaySo) {
  const Exported exported = Written(ThreeAxes());
  EXPECT_LT(LargestDifference(ThreeAxes(), exported.text), kFloat_deg_s);
  EXPECT_THAT(exported.notes, Contains(HasSubstr("gyro y: scale factor and misalignment")));
  EXPECT_THAT(Flat(exported.text), HasSubstr("0.005000 0.980000 0.015000"));
}

TEST_P(Autopilots, TakeEffectsOfTheTemperatureIntoTheCubicAsFarAsItGoes) {
  Calibration calibration = WithoutMatrix();
  calibration.channels[0].model.bias_deg_s = {0.5, 0.02, -0.001, 2e-5, -3e-5, 1e-5};
  calibration.channels[2].model.terms = {CurveTerm("T", {24.0, 27.0}, {0.0, 0.05})};
  const Exported exported = Written(calibration);
  for (const char* axis : {"gyro x", "gyro z"})
    EXPECT_THAT(exported.notes, Contains(testing::AllOf(HasSubstr(axis), HasSubstr("no cubic"))));
  double promised = 0.0;
  for (const std::string& note : exported.notes) {
    const std::vector<double> off = NumbersAfter(note, "off by up to");
    if (!off.empty()) promised = std::max(promised, off[0]);
  }
  // It is said at 64 points, to two digits.
  EXPECT_LT(LargestDifference(calibration, exported.text), 1.1 * promised + kFloat_deg_s);
  EXPECT_GT(LargestDifference(calibration, exported.text), 0.3 * promised);
}

// The rate that the offset is of is the driver's.
TEST_P(Autopilots, SayWhichZeroTheDriverHasToTakeOff) {
  Calibration calibration = WithoutMatrix();
  EXPECT_THAT(Flat(Written(calibration).text), testing::Not(HasSubstr("count of zero")));
  calibration.gyro_lsb_zero = 32768.0;
  EXPECT_THAT(Flat(Written(calibration).text), HasSubstr("counts less 32768"));
}

TEST_P(Autopilots, SayWhichEffectsTheyCannotHold) {
  Calibration calibration = WithoutMatrix();
  calibration.channels[0].model.terms = {CatalogueTerm("bias.g_linear", {0.1, 0.2, -0.3}),
                                         CatalogueTerm("scale.cubic", {1e-6})};
  const Exported exported = Written(calibration);
  EXPECT_THAT(exported.notes, Contains(HasSubstr("gyro x: bias.g_linear, scale.cubic left out")));
  EXPECT_THAT(Flat(exported.text), HasSubstr("bias.g_linear"));
}

TEST_P(Autopilots, WithoutTemperaturesHaveAConstantOffsetInsteadAndSaySo) {
  Calibration calibration = WithoutMatrix();
  for (auto& channel : calibration.channels) {
    calibration::ChannelModel& model = channel.model;
    model.bias_deg_s.resize(1);
    model.reference_degC = model.min_temperature_degC = model.max_temperature_degC = kMissing;
  }
  const Exported exported = Written(calibration);
  EXPECT_FALSE(GetParam().read(exported.text).contains(GetParam().thermal));
  EXPECT_THAT(exported.notes, Contains(HasSubstr("is written instead")));
  EXPECT_LT(LargestDifference(calibration, exported.text), kFloat_deg_s);
  EXPECT_EQ(exported.text.find("nan"), std::string::npos);
}

TEST_P(Autopilots, ShareTheTemperaturesThatAllAxesSaw) {
  Calibration calibration = WithoutMatrix();
  calibration.channels[0].model.min_temperature_degC = 22.0;
  calibration.channels[1].model.max_temperature_degC = 28.0;
  const Exported exported = Written(calibration);
  EXPECT_THAT(exported.notes, Contains(HasSubstr("22 .. 28 degC")));
  calibration.channels[1].model.max_temperature_degC = 21.0;
  EXPECT_THROW(Written(calibration), DataError);
}

TEST_P(Autopilots, OfOneAxisLeaveTheOthersAlone) {
  Calibration calibration = WithoutMatrix();
  calibration.channels.erase(calibration.channels.begin());
  const Exported exported = Written(calibration);
  EXPECT_THAT(exported.notes, Contains(HasSubstr("gyro x: not in the calibration")));
  EXPECT_LT(LargestDifference(calibration, exported.text), kFloat_deg_s);
  const State state{{kUnits, 0.0, 0.0}, 25.0, 0.0};
  EXPECT_NEAR(GetParam().rate(GetParam().read(exported.text), state)[0], 1.0, kFloat_deg_s);
}

TEST_P(Autopilots, HaveWorkedExamplesThatAreRight) {
  const std::string text = Written(WithoutMatrix()).text;
  const std::vector<double> offset = NumbersAfter(text, "at 25.00 degC the offset is");
  ASSERT_EQ(offset.size(), 3u);
  const Vector3 rate = GetParam().rate(GetParam().read(text), State{});
  for (std::size_t c = 0; c < 3; ++c) EXPECT_NEAR(-rate[c], kDegPerRad * offset[c], kFloat_deg_s);
}

INSTANTIATE_TEST_SUITE_P(All, Autopilots,
                         testing::Values(Autopilot{"Px4", "px4", ReadPx4, ByPx4, "TC_G_ENABLE"},
                                         Autopilot{"ArduPilot", "ardupilot", ReadArduPilot,
                                                   ByArduPilot, "INS_TCAL1_ENABLE"}),
                         [](const auto& tested) { return std::string(tested.param.name); });

}  // namespace
}  // namespace gyrobench::exporting
