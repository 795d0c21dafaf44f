// What is said of a key of a scenario file, and the keys of its [gyro] (see scenario_keys.h).
#pragma once

#include <string_view>

#include "config/scenario.h"

namespace gyrobench::config {

struct KeyInfo {
  std::string_view unit;
  double min, max;
  std::string_view help;
};

// A rate error or a scale error beyond this is a wrong number, not an imperfection.
inline constexpr double kMostRel = 0.2;

template <class V>
void Describe(V& v, GyroScenario::BiasStep& s) {
  v.Number("at_s", s.at_s, {"s", 0, 1e9, "the bias jumps ..."});
  v.Array("deg_s", s.deg_s, {"deg/s", -500, 500, "... by this much, x y z"});
}

template <class V>
void Describe(V& v, GyroScenario::Tone& s) {
  v.Number("frequency_hz", s.frequency_hz,
           {"Hz", 0, 1e5, "interference; beyond half the sample rate it aliases"});
  v.Number("phase_deg", s.phase_deg, {"deg", -360, 360, "at power-on (drawn when drawn.phases)"});
  v.Array("deg_s", s.deg_s, {"deg/s", -500, 500, "amplitude, x y z"});
}

template <class V>
void DescribeRateTerms(V& v, GyroScenario& s) {
  v.Array("scale_rel", s.scale_rel, {"1", -kMostRel, kMostRel, "scale error"});
  v.Array("cross_axis_rel", s.cross_axis_rel,
          {"1", -kMostRel, kMostRel, "3x3, off-diagonal of M; diagonal not used"});
  v.Array("scale_temperature_per_degC", s.scale_temperature_per_degC,
          {"1/degC", -0.01, 0.01, "c w (T-T0)"});
  v.Array("scale_temperature_per_degC2", s.scale_temperature_per_degC2,
          {"1/degC2", -0.001, 0.001, "c w (T-T0)^2"});
  v.Array("scale_g_per_g", s.scale_g_per_g, {"1/g", -kMostRel, kMostRel, "3x3, c_ij g_j w_i"});
  v.Array("quadratic_odd_per_deg_s", s.quadratic_odd_per_deg_s,
          {"1/(deg/s)", -0.01, 0.01, "c w abs(w)"});
  v.Array("quadratic_even_per_deg_s", s.quadratic_even_per_deg_s,
          {"1/(deg/s)", -0.01, 0.01, "c w^2"});
  v.Array("cubic_per_deg2_s2", s.cubic_per_deg2_s2, {"1/(deg/s)^2", -1e-4, 1e-4, "c w^3"});
  v.Array("asymmetry_rel", s.asymmetry_rel, {"1", -kMostRel, kMostRel, "c abs(w)"});
}

template <class V>
void DescribeBiasTerms(V& v, GyroScenario& s) {
  v.Number("reference_degC", s.reference_degC,
           {"degC", -60, 125, "T0 of all polynomials in temperature"});
  v.Array("bias_deg_s", s.bias_deg_s, {"deg/s", -500, 500, "bias at T0"});
  v.Array("bias_deg_s_per_degC", s.bias_deg_s_per_degC, {"deg/s/degC", -10, 10, "linear in T-T0"});
  v.Array("bias_deg_s_per_degC2", s.bias_deg_s_per_degC2, {"deg/s/degC2", -1, 1, "quadratic"});
  v.Array("bias_deg_s_per_degC3", s.bias_deg_s_per_degC3, {"deg/s/degC3", -0.1, 0.1, "cubic"});
  v.Number("bias_jump_at_degC", s.bias_jump_at_degC,
           {"degC", -60, 125, "above this temperature the bias is ..."});
  v.Array("bias_jump_deg_s", s.bias_jump_deg_s, {"deg/s", -500, 500, "... larger by this much"});
  v.Array("g_linear_deg_s_per_g", s.g_linear_deg_s_per_g, {"deg/s/g", -10, 10, "3x3, k g"});
  v.Array("g_linear_deg_s_per_g_per_degC", s.g_linear_deg_s_per_g_per_degC,
          {"deg/s/g/degC", -1, 1, "3x3, k g (T-T0)"});
  v.Array("g_squared_deg_s_per_g2", s.g_squared_deg_s_per_g2,
          {"deg/s/g2", -10, 10, "3x3, k_ij g_j^2"});
  v.Array("temperature_rate_deg_s_per_degC_s", s.temperature_rate_deg_s_per_degC_s,
          {"deg/s/(degC/s)", -100, 100, "c dT/dt"});
  v.Number("hysteresis_play_degC", s.hysteresis_play_degC,
           {"degC", 0, 50, "r, half-width of the play P_r"});
  v.Array("hysteresis_deg_s_per_degC", s.hysteresis_deg_s_per_degC,
          {"deg/s/degC", -10, 10, "c (P_r[T] - T)"});
  v.Number("warm_up_time_constant_s", s.warm_up_time_constant_s,
           {"s", 0.01, 1e6, "tau, from power-on"});
  v.Array("warm_up_deg_s", s.warm_up_deg_s, {"deg/s", -500, 500, "A exp(-t/tau)"});
  v.Array("vibration_deg_s_per_g2", s.vibration_deg_s_per_g2,
          {"deg/s/g2", -1e4, 1e4, "c (mean square of the vibration)"});
  v.List("bias_step", s.bias_steps);
  v.List("tone", s.tones);
}

template <class V>
void Describe(V& v, GyroScenario& s) {
  DescribeRateTerms(v, s);
  DescribeBiasTerms(v, s);
  v.Array("angle_random_walk_deg_sqrt_s", s.angle_random_walk_deg_sqrt_s,
          {"deg/sqrt(s)", 0, 10, "N; a sample at rate f has noise N sqrt(f)"});
  v.Array("bias_random_walk_deg_s_sqrt_s", s.bias_random_walk_deg_s_sqrt_s,
          {"deg/s/sqrt(s)", 0, 10, "K"});
  v.Array("flicker_deg_s", s.flicker_deg_s,
          {"deg/s", 0, 10, "B, 1/f bias noise; Allan floor 0.664 B"});
  v.Number("heavy_tail_fraction", s.heavy_tail_fraction,
           {"1", 0, 1, "of the samples whose white noise is larger ..."});
  v.Number("heavy_tail_factor", s.heavy_tail_factor, {"1", 0, 1000, "... by this factor"});
  v.Number("filter_delay_rel", s.filter_delay_rel,
           {"1", -0.5, 5, "error of the data sheet's group delay"});
  v.Number("extra_lag_s", s.extra_lag_s, {"s", 0, 1, "first-order lag before the filter"});
  v.Number("sample_clock_rel", s.sample_clock_rel,
           {"1", -kMostRel, kMostRel, "rate error of the sensor's own clock"});
}

}  // namespace gyrobench::config
