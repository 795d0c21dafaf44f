#include "tests/export/export_sample.h"

#include <cctype>
#include <sstream>
#include <utility>

#include "calibration/artefact/corrector.h"

namespace gyrobench::exporting {

using calibration::Calibration;
using calibration::ModelTerm;

Calibration ThreeAxes() {
  Calibration out;
  out.sensor = "MPU-17";
  out.created = "2026-11-21T15:30:12Z";
  constexpr std::array<Vector3, 3> kM = {
      {{1.01, 0.02, -0.01}, {0.005, 0.98, 0.015}, {-0.02, 0.01, 1.03}}};
  for (std::size_t c = 0; c < 3; ++c) {
    calibration::ChannelCalibration channel;
    channel.model.axis = static_cast<SensorAxis>(c);
    channel.model.unit = "LSB";
    channel.model.units_per_deg_s = kUnits;
    channel.model.m_row = kM[c];
    channel.model.reference_degC = 26.0;
    channel.model.bias_deg_s = {0.5 - 0.3 * static_cast<double>(c), 0.02, -0.001, 2e-5};
    channel.model.min_temperature_degC = 20.0;
    channel.model.max_temperature_degC = 30.0;
    channel.model.max_rate_deg_s = 45.0;
    channel.noise.angle_random_walk_deg_sqrt_s = 0.0035 + 1e-4 * static_cast<double>(c);
    channel.noise.bias_random_walk_deg_s_sqrt_s = 2e-4 - 1e-5 * static_cast<double>(c);
    out.channels.push_back(channel);
  }
  return out;
}

Calibration WithoutMatrix() {
  Calibration out = ThreeAxes();
  for (std::size_t c = 0; c < 3; ++c) {
    out.channels[c].model.m_row = {};
    out.channels[c].model.m_row[c] = 1.0;
  }
  return out;
}

ModelTerm CatalogueTerm(const std::string& id, std::vector<double> coefficients,
                        std::vector<double> nonlinear) {
  ModelTerm term;
  term.id = id;
  term.coefficients = std::move(coefficients);
  term.nonlinear = std::move(nonlinear);
  term.reference_degC = 24.0;
  return term;
}

ModelTerm ComposedTerm(std::vector<std::string> factors, double coefficient) {
  ModelTerm term;
  term.id = "composed";
  term.origin = calibration::EffectOrigin::kComposed;
  term.coefficients = {coefficient};
  term.offsets.assign(factors.size(), 0.25);
  term.factors = std::move(factors);
  return term;
}

ModelTerm CurveTerm(const std::string& factor, std::vector<double> knots,
                    std::vector<double> values) {
  ModelTerm term;
  term.id = "empirical(" + factor + ")";
  term.origin = calibration::EffectOrigin::kEmpirical;
  term.factors = {factor};
  term.knots = std::move(knots);
  term.coefficients = std::move(values);
  return term;
}

Exported Write(const Calibration& calibration, std::string_view format, const std::string& target) {
  return FindFormat(format)->write(calibration,
                                   {"cal.json", std::string(64, 'a'), "0.1.0", target});
}

std::vector<State> StatesAt(double temperature_degC) {
  std::vector<State> states;
  for (const double x : {-60.0, -44.0, -3.0, 0.0, 17.0, 43.0, 70.0}) {
    for (const double y : {-41.0, 0.5, 30.0}) {
      for (const double z : {-20.0, 0.0, 41.0}) {
        State state;
        state.xi = {kUnits * x, kUnits * y, kUnits * z};
        state.temperature_degC = temperature_degC;
        state.t_s = 0.1 * static_cast<double>(states.size());
        states.push_back(state);
      }
    }
  }
  return states;
}

std::vector<Vector3> Corrected(const Calibration& calibration, const std::vector<State>& states) {
  MeasurementInfo info;
  info.gyro_present = info.accel_present = {true, true, true};
  info.temperature_present = true;
  info.gyro_units_per_deg_s = kUnits;
  calibration::Corrector corrector(calibration, info, {.any_sensor = true});
  for (const State& state : states) {
    GyroSample sample;
    sample.t_s = state.t_s;
    sample.xi = state.xi;
    sample.accel_g = kGravity;
    sample.temperature_degC = state.temperature_degC;
    corrector.Add(sample, {});
  }
  corrector.End();
  std::vector<Vector3> rates;
  Vector3 rate;
  while (corrector.Next(&rate)) rates.push_back(rate);
  return rates;
}

std::string Flat(const std::string& text) {
  std::istringstream stream(text);
  std::string flat;
  for (std::string word; stream >> word;)
    if (word != "*" && word != "#") flat += (flat.empty() ? "" : " ") + word;
  return flat;
}

std::vector<double> NumbersAfter(const std::string& text, const std::string& before) {
  const std::string flat = Flat(text);
  const std::size_t at = flat.find(before);
  std::vector<double> numbers;
  if (at == std::string::npos) return numbers;
  std::string rest = flat.substr(at + before.size());
  for (char& letter : rest)
    if (std::string("{},").find(letter) != std::string::npos) letter = ' ';
  std::istringstream stream(rest);
  for (double number; stream >> number;) numbers.push_back(number);
  return numbers;
}

}  // namespace gyrobench::exporting
