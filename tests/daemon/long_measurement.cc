#include "tests/daemon/long_measurement.h"

#include <algorithm>
#include <cmath>

namespace gyrobench::daemon {
namespace {

constexpr double kRest_s = 20.0, kTurn_s = 3.0, kRate_deg_s = 30.0, kLsbPerDegS = 131.0;
constexpr double kReadings_hz = 10.0;

// Angle and rate of the table.
struct Motion {
  double angle_deg = 0.0, rate_deg_s = 0.0;
};

Motion At(double t_s) {
  const double cycle_s = 2.0 * (kRest_s + kTurn_s);
  const double in_cycle_s = std::fmod(t_s, cycle_s);
  const bool back = in_cycle_s >= 0.5 * cycle_s;
  const double turning_s = in_cycle_s - (back ? 0.5 * cycle_s : 0.0) - kRest_s;
  const double way_deg = kRate_deg_s * std::clamp(turning_s, 0.0, kTurn_s);
  const double sign = back ? -1.0 : 1.0;
  return {(back ? kRate_deg_s * kTurn_s : 0.0) + sign * way_deg,
          turning_s > 0.0 ? sign * kRate_deg_s : 0.0};
}

}  // namespace

MeasurementInfo LongMeasurement::Info() {
  MeasurementInfo info;
  info.gyro_unit = RateUnit::kLsb;
  info.gyro_present = {false, false, true};
  info.temperature_present = true;
  info.gyro_units_per_deg_s = kLsbPerDegS;
  info.reference = ReferenceKind::kStandAngles;
  info.stand_axis_present = {false, false, true};
  return info;
}

void LongMeasurement::FeedUntil(double end_s, MeasurementSink& sink) {
  while (TimeS() < end_s) {
    const double t_s = TimeS();
    GyroSample sample;
    sample.t_s = t_s;
    sample.xi = {
        kMissing, kMissing,
        std::round(kLsbPerDegS * At(t_s).rate_deg_s + static_cast<double>(samples_ % 3) - 1.0)};
    sample.temperature_degC = 25.0;
    sink.OnGyro(sample);
    ++samples_;
    if (t_s < static_cast<double>(readings_) / kReadings_hz) continue;
    AngleSample reading;
    reading.t_s = t_s;
    reading.axis = 2;
    reading.angle_deg = At(t_s).angle_deg;
    sink.OnAngle(reading);
    ++readings_;
  }
}

}  // namespace gyrobench::daemon
