// The model of one channel in numbers: what a trace ends with and a calibration is made of.
//
//   xi / s0 = sum_j M_cj w_j + sum_k b_k (T - T0)^k + sum of terms     [deg/s], c the channel
#pragma once

#include <array>
#include <optional>
#include <string>
#include <vector>

#include "base/measurement.h"
#include "calibration/effects/effect_kind.h"

namespace gyrobench::calibration {

// One effect with its numbers. Exactly one of the three forms:
//   catalogue   sum_j coefficients[j] basis_j(state; nonlinear)         (FindEffect(id)->basis)
//   composed    coefficients[0] * product over factors (factor - factor's offset)
//   empirical   curve through (knots[i], coefficients[i]) in factors[0]: straight between the
//               knots, constant outside
struct ModelTerm {
  std::string id;
  EffectOrigin origin = EffectOrigin::kCatalogue;
  EffectOwner owner = EffectOwner::kGyro;
  std::vector<double> coefficients;
  std::vector<double> nonlinear;
  std::size_t table_axis = 2;   // StandAxis, effects of one axis of the bench
  double reference_degC = 0.0;  // T0
  std::string covariate;        // column name, for bias.of and scale.of
  double covariate_mean = 0.0;
  // Composed, empirical. A factor: w, abs_w, w_x, w_y, w_z, g_x, g_y, g_z, T, dT_dt or a column's
  // name (calibration/effects/factor.h).
  std::vector<std::string> factors;
  std::vector<double> offsets;
  std::vector<double> knots;
  std::optional<ChosenOn> chosen_on = {};  // empty: of a file that does not say it
};

struct ChannelModel {
  SensorAxis axis = SensorAxis::kZ;
  std::string unit;                  // of xi: LSB, deg/s
  double units_per_deg_s = 1.0;      // s0, nominal
  std::array<double, 3> m_row = {};  // row of M; 0 where an axis never turned
  std::array<double, 3> m_row_std_error = {};
  double reference_degC = kMissing;  // T0; NaN: no temperature
  std::vector<double> bias_deg_s;    // b_0, b_1 ... about T0
  std::vector<ModelTerm> terms;      // all accepted effects, whoever owns them
  // Of: m_row of the axes that turned, its own first; one constant of the bias a measurement (their
  // mean is bias_deg_s[0]); the rest of bias_deg_s; then effect by effect its coefficients and
  // those of its non-linear parameters that were fitted. Square, symmetric; parameter_names says
  // which is which.
  std::vector<std::string> parameter_names;
  std::vector<double> covariance;
  // Where the data were.
  double min_temperature_degC = kMissing, max_temperature_degC = kMissing;
  double max_rate_deg_s = kMissing;
};

}  // namespace gyrobench::calibration
