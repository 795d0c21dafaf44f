// Short measurements made up sample by sample, for what the tracer does with bad ones. The sensor
// has no effect beyond the baseline; whatever is wrong with a story is put into it by its test.
#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <random>
#include <span>
#include <vector>

#include "base/measurement.h"
#include "calibration/signal/collector.h"
#include "tests/calibration/synthetic_bench.h"

namespace gyrobench::testing {

struct Story {
  double duration_s = 180.0;
  double gyro_hz = 50.0;
  double reference_hz = 25.0;
  std::uint64_t seed = 1;
  MeasurementInfo info;  // of Story(): counts, three axes, the stand's inner axis, temperature
  std::function<double(double)> rate_deg_s;  // of the inner axis
  std::function<double(double)> angle_deg;   // its integral
  std::function<double(double)> temperature_degC;
  std::vector<std::function<double(double)>> covariates;
  // Output of each channel in deg/s: scale times the turning axis's rate, and a bias.
  std::array<double, 3> scale = {0.004, -0.003, 1.012};
  double drift_deg_s_per_degC = 0.01;  // about 25 degC
  double white_deg_s = 0.025;          // of a sample
  double reading_deg = 0.004;          // of the reference
  // What happens to a sample on its way; false: it is lost.
  std::function<bool(GyroSample*)> spoil_gyro;
  std::function<bool(AngleSample*)> spoil_angle;

  // Turns of 90 deg at up to 60 deg/s to and fro, rests of 3 s between, a slow warm-up.
  Story();
  // The inner axis of such a motion, from its begin to its end.
  void Follow(const Motion& motion);
  // The channel that turns alone, and no accelerometer.
  void UseTurningChannelAlone();
  // One axis of the sensor's own, or a quaternion, in place of the stand.
  void UseSensorAngle(SensorAxis axis = SensorAxis::kZ);
  void UseOrientation();

  void Tell(MeasurementSink& sink) const;
  calibration::Recording Collect() const;
};

}  // namespace gyrobench::testing
