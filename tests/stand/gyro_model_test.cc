// Each term of the gyro against the convention: what it adds, and that it is nothing where it must
// be.
#include "stand/gyro_model.h"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <string>

namespace gyrobench::stand {
namespace {

GyroInput Somewhere() {
  return {.rate_deg_s = {3.0, -5.0, 20.0},
          .g = {0.3, -0.4, 0.866},
          .t_s = 7.0,
          .die_degC = 40.0,
          .die_rate_degC_s = 0.02,
          .vibration_g2 = 0.04};
}

struct Term {
  std::string name;
  std::function<void(config::GyroScenario&)> set;
  std::function<double(const GyroInput&)> z;  // what it adds to the z axis
};

const double kPi = 3.14159265358979323846;

const Term kTerms[] = {
    {"Scale", [](auto& s) { s.scale_rel[2] = 0.02; },
     [](const auto& in) { return 0.02 * in.rate_deg_s[2]; }},
    {"CrossAxis", [](auto& s) { s.cross_axis_rel[7] = 0.01; },
     [](const auto& in) { return 0.01 * in.rate_deg_s[1]; }},
    {"ScaleTemperature", [](auto& s) { s.scale_temperature_per_degC[2] = 3e-4; },
     [](const auto& in) { return 3e-4 * in.rate_deg_s[2] * (in.die_degC - 25); }},
    {"ScaleTemperature2", [](auto& s) { s.scale_temperature_per_degC2[2] = 3e-5; },
     [](const auto& in) { return 3e-5 * in.rate_deg_s[2] * std::pow(in.die_degC - 25, 2); }},
    {"BiasCubic",
     [](auto& s) {
       s.bias_deg_s[2] = 1.0;
       s.bias_deg_s_per_degC[2] = 0.02;
       s.bias_deg_s_per_degC2[2] = 3e-4;
       s.bias_deg_s_per_degC3[2] = -4e-6;
     },
     [](const auto& in) {
       const double d = in.die_degC - 25;
       return 1.0 + 0.02 * d + 3e-4 * d * d - 4e-6 * d * d * d;
     }},
    {"GLinear", [](auto& s) { s.g_linear_deg_s_per_g[6] = 0.05; },
     [](const auto& in) { return 0.05 * in.g[0]; }},
    {"GLinearTemperature", [](auto& s) { s.g_linear_deg_s_per_g_per_degC[8] = 0.002; },
     [](const auto& in) { return 0.002 * in.g[2] * (in.die_degC - 25); }},
    {"GSquared", [](auto& s) { s.g_squared_deg_s_per_g2[7] = 0.01; },
     [](const auto& in) { return 0.01 * in.g[1] * in.g[1]; }},
    {"ScaleG", [](auto& s) { s.scale_g_per_g[8] = 5e-4; },
     [](const auto& in) { return 5e-4 * in.g[2] * in.rate_deg_s[2]; }},
    {"QuadraticOdd", [](auto& s) { s.quadratic_odd_per_deg_s[2] = 1e-4; },
     [](const auto& in) { return 1e-4 * in.rate_deg_s[2] * std::abs(in.rate_deg_s[2]); }},
    {"QuadraticEven", [](auto& s) { s.quadratic_even_per_deg_s[2] = 1e-4; },
     [](const auto& in) { return 1e-4 * std::pow(in.rate_deg_s[2], 2); }},
    {"Cubic", [](auto& s) { s.cubic_per_deg2_s2[2] = 1e-6; },
     [](const auto& in) { return 1e-6 * std::pow(in.rate_deg_s[2], 3); }},
    {"Asymmetry", [](auto& s) { s.asymmetry_rel[2] = 1e-3; },
     [](const auto& in) { return 1e-3 * std::abs(in.rate_deg_s[2]); }},
    {"TemperatureRate", [](auto& s) { s.temperature_rate_deg_s_per_degC_s[2] = 0.5; },
     [](const auto& in) { return 0.5 * in.die_rate_degC_s; }},
    {"WarmUp",
     [](auto& s) {
       s.warm_up_deg_s[2] = 0.2;
       s.warm_up_time_constant_s = 30;
     },
     [](const auto& in) { return 0.2 * std::exp(-in.t_s / 30); }},
    {"Vibration", [](auto& s) { s.vibration_deg_s_per_g2[2] = 2.0; },
     [](const auto& in) { return 2.0 * in.vibration_g2; }},
    {"BiasStep",
     [](auto& s) {
       s.bias_steps = {{.at_s = 6, .deg_s = {0, 0, 0.3}}, {.at_s = 8, .deg_s = {0, 0, 9}}};
     },
     [](const auto& in) { return in.t_s >= 6 ? 0.3 : 0.0; }},
    {"Tone",
     [](auto& s) {
       s.tones = {{.frequency_hz = 0.31, .phase_deg = 20, .deg_s = {0, 0, 0.1}}};
     },
     [](const auto& in) { return 0.1 * std::sin(2 * kPi * 0.31 * in.t_s + 20 * kPi / 180); }},
    {"BiasJump",
     [](auto& s) {
       s.bias_jump_at_degC = 35;
       s.bias_jump_deg_s[2] = 0.4;
     },
     [](const auto& in) { return in.die_degC > 35 ? 0.4 : 0.0; }},
};

class GyroTerm : public testing::TestWithParam<Term> {};

TEST_P(GyroTerm, AddsWhatTheConventionSaysAndOnlyToItsAxis) {
  config::GyroScenario scenario;
  GetParam().set(scenario);
  GyroModel model(scenario);
  for (int sign : {1, -1}) {
    GyroInput in = Somewhere();
    in.rate_deg_s[2] *= sign;
    in.g[2] *= sign;
    in.die_degC += sign < 0 ? -20.0 : 0.0;
    in.t_s += sign < 0 ? -2.0 : 0.0;
    const Triple out = model.Output(in);
    EXPECT_NEAR(out[2], in.rate_deg_s[2] + GetParam().z(in), 1e-12);
    EXPECT_EQ(out[0], in.rate_deg_s[0]);
    EXPECT_EQ(out[1], in.rate_deg_s[1]);
  }
}

INSTANTIATE_TEST_SUITE_P(All, GyroTerm, testing::ValuesIn(kTerms),
                         [](const auto& test) { return test.param.name; });

// The same loop of temperature gives the same closed curve, with the width 2 r c.
TEST(Hysteresis, ItsLoopClosesAndIsAsWideAsThePlay) {
  config::GyroScenario scenario;
  scenario.hysteresis_play_degC = 3.0;
  scenario.hysteresis_deg_s_per_degC[0] = 0.02;
  GyroModel model(scenario);
  const auto at = [&](double degC) {
    GyroInput in;
    in.die_degC = degC;
    return model.Output(in)[0];
  };
  double up = 0.0;
  double down = 0.0;
  for (int loop = 0; loop < 3; ++loop) {
    for (double T = 0; T <= 40; T += 0.5) {
      const double b = at(T);
      if (T == 20) up = b;
    }
    for (double T = 40; T >= 0; T -= 0.5) {
      const double b = at(T);
      if (T == 20) down = b;
    }
    if (loop > 0) {
      EXPECT_NEAR(down - up, 2 * 3.0 * 0.02, 1e-12);
    }
  }
  EXPECT_NEAR(up, -0.06, 1e-12);
}

}  // namespace
}  // namespace gyrobench::stand
