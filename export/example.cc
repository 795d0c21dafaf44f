#include "export/example.h"

#include <fmt/format.h>

#include <cmath>

#include "base/error.h"
#include "calibration/artefact/corrector.h"
#include "export/linear_model.h"

namespace gyrobench::exporting {
namespace {

constexpr double kUnknownRate_deg_s = 20.0;
// A state is known once there are samples on either side for as long as the corrector smooths.
constexpr int kSamples = 25;
constexpr double kInterval_s = 0.5;

MeasurementInfo SensorOf(const LinearModel& model) {
  MeasurementInfo info;
  info.source = "the worked example";
  info.gyro_unit = model.unit == "LSB" ? RateUnit::kLsb : RateUnit::kDegPerSecond;
  info.gyro_present = info.accel_present = {true, true, true};
  info.temperature_present = true;
  return info;
}

// A third of the way up from the low end: a temperature at which every term of b(T) says something.
double TemperatureOf(const LinearModel& model) {
  const TemperatureRange range = CommonTemperatures(model);
  if (!range.known()) return Example().temperature_degC;
  const double third = range.low_degC + (range.high_degC - range.low_degC) / 3.0;
  const double rounded = std::round(10.0 * third) / 10.0;
  return rounded >= range.low_degC && rounded <= range.high_degC ? rounded : third;
}

calibration::Vector3 OutputOf(const LinearModel& model) {
  constexpr calibration::Vector3 kShares = {0.5, -0.3, 0.2};
  calibration::Vector3 xi = {};
  for (std::size_t c = 0; c < 3; ++c) {
    if (model.axes[c] == nullptr) continue;
    const double largest = model.axes[c]->max_rate_deg_s;
    const double rate = kShares[c] * (std::isfinite(largest) ? largest : kUnknownRate_deg_s);
    xi[c] = model.unit == "LSB" ? std::round(model.units_per_deg_s[c] * rate)
                                : std::round(100.0 * rate) / 100.0;
  }
  return xi;
}

}  // namespace

Example WorkedExample(const calibration::Calibration& calibration) {
  const LinearModel model = MakeLinearModel(calibration);
  Example example;
  example.temperature_degC = TemperatureOf(model);
  example.xi = OutputOf(model);
  const calibration::CorrectorOptions options{.any_sensor = true};
  MeasurementInfo sensor = SensorOf(model);
  sensor.gyro_lsb_zero = calibration.gyro_lsb_zero;
  calibration::Corrector corrector(calibration, sensor, options);
  for (int i = 0; i < kSamples; ++i) {
    GyroSample sample;
    sample.t_s = i * kInterval_s;
    sample.xi = example.xi;
    sample.accel_g = example.gravity_g;
    sample.temperature_degC = example.temperature_degC;
    corrector.Add(sample, {});
  }
  corrector.End();
  corrector.Next(&example.rate_deg_s);
  for (std::size_t c = 0; c < 3; ++c) {
    if (std::isfinite(example.rate_deg_s[c])) continue;
    throw DataError(fmt::format(
        "gyro {}: the effects of the calibration have no solution at {} {} and {} degC, in the "
        "midst of its range: nothing could be made of it",
        kAxisNames[c], example.xi[c], model.unit, example.temperature_degC));
  }
  return example;
}

std::string ListOf(const calibration::Vector3& values) {
  return fmt::format("{}, {}, {}", values[0], values[1], values[2]);
}

}  // namespace gyrobench::exporting
