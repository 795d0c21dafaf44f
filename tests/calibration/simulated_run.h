// Runs made up at the level of the signals, sent through the door that real ones come through.
// Written apart from the estimators and from the virtual stand.
#pragma once

#include <cstdint>
#include <functional>
#include <vector>

#include "base/measurement.h"
#include "tests/calibration/dense_gls.h"

namespace gyrobench::testing {

// Turns with rests between. The defaults are those of the table of estimators in the design.
struct TurnSchedule {
  double rate_deg_s = 20.0;
  double angle_deg = 9.0;
  int turns = 40;
  bool back_and_forth = false;
  double rest_s = 2.0;
  // Steep, so that a turn takes about angle / rate.
  double acceleration_deg_s2 = 800.0;

  double TurnTime() const;
  double Duration() const { return rest_s + turns * (TurnTime() + rest_s); }
};

struct SimulatedSensor {
  double n = 0.0035;                   // angle random walk [deg/sqrt(s)]
  double k = 1e-4;                     // bias random walk [deg/s/sqrt(s)]
  double stop_half_width_deg = 0.025;  // reference error, uniform at each stop
  double reading_noise_deg = 0.001;
  double nominal_lsb_per_deg_s = 131.0;
  double scale_error = 0.015;  // xi / nominal = (1 + scale_error) w + bias
  double bias_deg_s = 0.2;
  double gyro_rate_hz = 200.0;
  double reference_rate_hz = 50.0;
  double latency_s = 0.0;  // of the reference: a reading shows the angle of so long before
  bool stop_accuracy_known = true;

  double alpha() const { return 1.0 / (nominal_lsb_per_deg_s * (1.0 + scale_error)); }
};

// Angle of the table [deg] at a time of the schedule.
double TableAngle(const TurnSchedule& schedule, double t_s);

// Sends the run into `sink`: inner axis of a stand turning, gyro z. The sensor averages over its
// sample interval (exact integral, half an interval of latency). After every rest and turn
// `segment_end` is called, when given.
void SimulateTurns(const TurnSchedule& schedule, const SimulatedSensor& sensor, std::uint64_t seed,
                   MeasurementSink* sink, const std::function<void()>& segment_end = {});

// Standard deviation of the scale factor, relative, at the Cramer-Rao bound: dense Fisher
// information with the true noise.
double ScaleBound(const TurnSchedule& schedule, const SimulatedSensor& sensor);

// A sensor that warms up at rest: T = end - (end - start) exp(-t / tau), beta a polynomial of T -
// 30 degC.
struct WarmUp {
  double duration_s = 900.0;
  double start_degC = 22.0, end_degC = 38.0, tau_s = 250.0;
  double thermometer_noise_degC = 0.02;
  std::vector<double> beta_deg_s = {0.5, 0.05, -0.003, 0.0003};

  double Temperature(double t_s) const;
  double Beta(double temperature_degC) const;
};

void SimulateWarmUp(const WarmUp& warm_up, const SimulatedSensor& sensor, std::uint64_t seed,
                    MeasurementSink* sink);

// Root mean square over the range of temperature of the curve's standard deviation [deg/s], at the
// bound.
double CurveBound(const WarmUp& warm_up, const SimulatedSensor& sensor);

}  // namespace gyrobench::testing
