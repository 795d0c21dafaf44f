#include "stand/gyro_model.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "stand/motion.h"

namespace gyrobench::stand {
namespace {

template <class Array>
bool Any(const Array& values) {
  return std::ranges::any_of(values, [](double v) { return v != 0.0; });
}

void AddProduct(const Square& k, const Triple& v, double factor, Triple& out) {
  for (std::size_t i = 0; i < 3; ++i) {
    out[i] += factor * (k[3 * i] * v[0] + k[3 * i + 1] * v[1] + k[3 * i + 2] * v[2]);
  }
}

}  // namespace

GyroModel::GyroModel(const config::GyroScenario& s) : scenario_(s), m_(s.cross_axis_rel) {
  for (std::size_t i = 0; i < 3; ++i) m_[4 * i] = 1.0 + s.scale_rel[i];
  has_nonlinearity_ = Any(s.quadratic_odd_per_deg_s) || Any(s.quadratic_even_per_deg_s) ||
                      Any(s.cubic_per_deg2_s2) || Any(s.asymmetry_rel);
  has_scale_g_ = Any(s.scale_g_per_g);
  has_g_temperature_ = Any(s.g_linear_deg_s_per_g_per_degC);
  has_g_squared_ = Any(s.g_squared_deg_s_per_g2);
  has_thermal_extras_ = Any(s.bias_jump_deg_s) || Any(s.temperature_rate_deg_s_per_degC_s) ||
                        Any(s.hysteresis_deg_s_per_degC);
  has_warm_up_ = Any(s.warm_up_deg_s);
  has_vibration_ = Any(s.vibration_deg_s_per_g2);
}

Triple GyroModel::Output(const GyroInput& input) {
  Triple out = {};
  AddProduct(m_, input.rate_deg_s, 1.0, out);
  AddRateTerms(input, out);
  AddGravityTerms(input, out);
  AddThermalTerms(input, out);
  AddTimeTerms(input, out);
  return out;
}

void GyroModel::AddRateTerms(const GyroInput& in, Triple& out) const {
  const double dT = in.die_degC - scenario_.reference_degC;
  for (std::size_t i = 0; i < 3; ++i) {
    const double w = in.rate_deg_s[i];
    out[i] +=
        w * dT *
        (scenario_.scale_temperature_per_degC[i] + scenario_.scale_temperature_per_degC2[i] * dT);
    if (has_nonlinearity_) {
      out[i] += scenario_.quadratic_odd_per_deg_s[i] * w * std::abs(w);
      out[i] += scenario_.quadratic_even_per_deg_s[i] * w * w;
      out[i] += scenario_.cubic_per_deg2_s2[i] * w * w * w;
      out[i] += scenario_.asymmetry_rel[i] * std::abs(w);
    }
    if (has_scale_g_) {
      const double* c = &scenario_.scale_g_per_g[3 * i];
      out[i] += (c[0] * in.g[0] + c[1] * in.g[1] + c[2] * in.g[2]) * w;
    }
  }
}

void GyroModel::AddGravityTerms(const GyroInput& in, Triple& out) const {
  AddProduct(scenario_.g_linear_deg_s_per_g, in.g, 1.0, out);
  if (has_g_temperature_) {
    AddProduct(scenario_.g_linear_deg_s_per_g_per_degC, in.g,
               in.die_degC - scenario_.reference_degC, out);
  }
  if (has_g_squared_) {
    const Triple g2 = {in.g[0] * in.g[0], in.g[1] * in.g[1], in.g[2] * in.g[2]};
    AddProduct(scenario_.g_squared_deg_s_per_g2, g2, 1.0, out);
  }
}

void GyroModel::AddThermalTerms(const GyroInput& in, Triple& out) {
  const auto& s = scenario_;
  const double dT = in.die_degC - s.reference_degC;
  for (std::size_t i = 0; i < 3; ++i) {
    out[i] +=
        s.bias_deg_s[i] + dT * (s.bias_deg_s_per_degC[i] +
                                dT * (s.bias_deg_s_per_degC2[i] + dT * s.bias_deg_s_per_degC3[i]));
  }
  if (!has_thermal_extras_) return;
  if (!hysteresis_begun_) hysteresis_follower_degC_ = in.die_degC;
  hysteresis_begun_ = true;
  hysteresis_follower_degC_ =
      Follow(hysteresis_follower_degC_, in.die_degC, s.hysteresis_play_degC);
  for (std::size_t i = 0; i < 3; ++i) {
    out[i] += s.temperature_rate_deg_s_per_degC_s[i] * in.die_rate_degC_s;
    out[i] += s.hysteresis_deg_s_per_degC[i] * (hysteresis_follower_degC_ - in.die_degC);
    if (in.die_degC > s.bias_jump_at_degC) out[i] += s.bias_jump_deg_s[i];
  }
}

void GyroModel::AddTimeTerms(const GyroInput& in, Triple& out) const {
  const auto add = [&out](const Triple& amplitude, double factor) {
    for (std::size_t i = 0; i < 3; ++i) out[i] += amplitude[i] * factor;
  };
  if (has_warm_up_) {
    add(scenario_.warm_up_deg_s, std::exp(-in.t_s / scenario_.warm_up_time_constant_s));
  }
  if (has_vibration_) add(scenario_.vibration_deg_s_per_g2, in.vibration_g2);
  for (const auto& step : scenario_.bias_steps) {
    if (in.t_s >= step.at_s) add(step.deg_s, 1.0);
  }
  for (const auto& tone : scenario_.tones) {
    const double turns = tone.frequency_hz * in.t_s + tone.phase_deg / 360.0;
    add(tone.deg_s, std::sin(2.0 * std::numbers::pi * turns));
  }
}

}  // namespace gyrobench::stand
