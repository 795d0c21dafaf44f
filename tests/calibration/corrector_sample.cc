#include "tests/calibration/corrector_sample.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

namespace gyrobench::calibration {

Vector3 TrueRate(double t) {
  return {12.0 * std::sin(0.5 * t), 25.0 * std::cos(0.31 * t), 40.0 * std::sin(0.2 * t + 1.0)};
}
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

GyroSample Sample(double t, const Calibration& calibration, const Extra& extra) {
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

double LargestError(const std::vector<Vector3>& rates, std::vector<std::size_t> axes) {
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
               std::vector<double> nonlinear) {
  ModelTerm term;
  term.id = id;
  term.coefficients = std::move(coefficients);
  term.nonlinear = std::move(nonlinear);
  term.reference_degC = 26.0;
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

}  // namespace gyrobench::calibration
