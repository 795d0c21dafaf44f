#include "tests/fuzz/calibration_laws.h"

#include <cmath>
#include <nlohmann/json.hpp>

#include "base/error.h"
#include "calibration/artefact/calibration_file.h"
#include "calibration/artefact/corrector.h"
#include "export/exporter.h"
#include "recording/run_directory.h"
#include "tests/fuzz/laws.h"

namespace gyrobench::testing {
namespace {

using calibration::Calibration;
using calibration::Corrector;
using calibration::EffectOrigin;
using calibration::EffectOwner;
using calibration::ModelTerm;

ModelTerm Term(const std::string& id, std::vector<double> coefficients,
               EffectOrigin origin = EffectOrigin::kCatalogue) {
  ModelTerm term;
  term.id = id;
  term.origin = origin;
  term.coefficients = std::move(coefficients);
  return term;
}

calibration::ChannelModel SampleModel(SensorAxis axis) {
  calibration::ChannelModel model;
  const auto own = static_cast<std::size_t>(axis);
  model.axis = axis;
  model.unit = "LSB";
  model.units_per_deg_s = 131.0;
  model.m_row = {0.011, 0.002, -0.007};
  model.m_row.at(own) = 1.015;
  model.m_row_std_error = {1e-5, 2e-5, 3e-5};
  model.reference_degC = 31.25;
  model.bias_deg_s = {0.1, -0.03, 1e-5};
  model.terms = {Term("scale.temperature", {2.5e-4}),
                 Term("bias.hysteresis", {0.02}),
                 Term("angle.eccentricity_1", {0.01, 0.02}),
                 Term("bias.of(supply_v)", {0.7}),
                 Term("composed(g_x*T)", {1e-3}, EffectOrigin::kComposed),
                 Term("empirical(T)", {0.1, 0.3, -0.2}, EffectOrigin::kEmpirical)};
  model.terms[1].nonlinear = {2.25};
  model.terms[2].owner = EffectOwner::kReference;
  model.terms[3].covariate = "supply_v";
  model.terms[4].factors = {"g_x", "T"};
  model.terms[4].offsets = {0.0, 29.5};
  model.terms[5].factors = {"T"};
  model.terms[5].knots = {20.0, 25.5, 40.0};
  model.min_temperature_degC = 21.5;
  model.max_temperature_degC = 39.75;
  model.max_rate_deg_s = 41.5;
  return model;
}

// The data that the calibration says it is for: motion, and a temperature that changes.
MeasurementInfo InfoFor(const Calibration& calibration) {
  MeasurementInfo info;
  info.source = "samples";
  info.gyro_present = info.accel_present = {true, true, true};
  info.temperature_present = true;
  info.covariates = {"supply_v"};
  if (calibration.channels.empty()) return info;
  const auto& model = calibration.channels.front().model;
  info.gyro_unit = model.unit == "LSB" ? RateUnit::kLsb : RateUnit::kDegPerSecond;
  info.gyro_units_per_deg_s = model.units_per_deg_s;
  return info;
}

void Apply(const Calibration& calibration) {
  Corrector corrector(calibration, InfoFor(calibration), {.any_sensor = true});
  constexpr int kSamples = 200;
  for (int i = 0; i < kSamples; ++i) {
    const double t_s = 0.1 * i, supply_v = 5.0 + 0.1 * std::cos(t_s);
    GyroSample sample;
    sample.t_s = t_s;
    sample.xi = {1000.0 * std::sin(t_s), 30.0, i == 50 ? kMissing : -2000.0};
    sample.accel_g = {0.0, 0.1, 0.99};
    sample.temperature_degC = 20.0 + t_s;
    corrector.Add(sample, {&supply_v, 1});
  }
  corrector.End();
  int out = 0;
  for (Vector3 rate; corrector.Next(&rate); ++out) {
    for (const double w : rate) {
      if (std::isinf(w)) throw BrokenLaw("a corrected rate is infinite");
    }
  }
  if (out != kSamples) throw BrokenLaw("every sample comes out again");
}

void Export(const Calibration& calibration, const exporting::Format& format) {
  std::string text;
  try {
    text = format.write(calibration, {"cal.json", "", "0.1.0", "gyro.h"}).text;
  } catch (const DataError&) {
    return;  // refused with a reason
  }
  for (const char* no_number :
       {"(nan", "(-nan", "(inf", "\tnan", "\t-nan", "\tinf", ",nan", ",inf"}) {
    if (text.find(no_number) != std::string::npos)
      throw BrokenLaw(std::string("an export holds what is no number: ") + no_number);
  }
}

}  // namespace

std::string SampleCalibration() {
  Calibration calibration;
  calibration.sensor = "MPU-17";
  calibration.created = "2026-11-21T15:30:12Z";
  calibration.version = "0.1.0";
  calibration.inputs = {{"run.csv.gz", std::string(64, 'a'), 120000, 1200.125}};
  calibration.configuration = {{"seed", "7"}};
  for (const SensorAxis axis : {SensorAxis::kX, SensorAxis::kZ}) {
    calibration.channels.emplace_back().model = SampleModel(axis);
  }
  calibration::VectorCalibration& vector = calibration.vector.emplace();
  vector.matrix.emplace().m_covariance.assign(81, 1e-12);
  vector.matrix->a_covariance.assign(81, 1e-16);
  vector.split.emplace();
  vector.g_sensitivity.emplace().value[1] = {0.01, 0.02, kMissing};
  vector.accelerometer.emplace().check.emplace();
  return ToJson(calibration).dump(1);
}

bool DigestCalibration(const std::filesystem::path& file) {
  Calibration calibration;
  try {
    calibration = calibration::CalibrationFromJson(recording::ReadJson(file), file.string());
  } catch (const DataError& error) {
    if (std::string(error.what()).find(file.filename().string()) != std::string::npos) return false;
    throw BrokenLaw(std::string("an error names the file: ") + error.what());
  }
  const nlohmann::json written = ToJson(calibration);
  if (ToJson(calibration::CalibrationFromJson(written, "again")) != written) {
    throw BrokenLaw("what is read is written as the same");
  }
  for (const exporting::Format& format : exporting::Formats()) Export(calibration, format);
  try {
    Apply(calibration);
  } catch (const DataError&) {
    return true;  // of other data than these
  }
  return true;
}

}  // namespace gyrobench::testing
