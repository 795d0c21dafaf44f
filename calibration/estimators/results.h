// What an analysis says: the results that are published, recorded and printed.
#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "base/measurement.h"
#include "calibration/gls/noise_model.h"

namespace gyrobench::calibration {

// Zero-rate offset against temperature of one sensor axis:
//   beta(T) = sum c_j (T - reference_temperature_degC)^j     [output units], paper eq. (1)
struct BiasResult {
  SensorAxis axis = SensorAxis::kZ;
  std::string unit;                              // of the output: LSB, deg/s
  double reference_temperature_degC = kMissing;  // NaN: no temperature in the data, order 0
  double min_temperature_degC = kMissing;
  double max_temperature_degC = kMissing;
  double duration_s = 0.0;
  // Joint estimate: generalised least squares with angle and bias random walk.
  std::vector<double> coefficients;
  std::vector<double> std_errors;
  std::vector<std::vector<double>> covariance;
  double rms_error = kMissing;     // standard error of the curve, root mean square over the range
  double residual_rms = kMissing;  // of 1 s means about the curve
  // Standard deviation of the offset from rest to rest beyond noise and random walk, which the
  // errors allow for [output units]; 0 where none is seen. So many rests, or groups of neighbouring
  // ones, tell it.
  double offset_scatter = 0.0;
  std::int64_t offset_groups = 0;
  // The paper's: Kalman smoothing, then ordinary least squares of the order chosen for it.
  std::vector<double> paper_coefficients;
  double paper_rms_error = kMissing;  // of the smoothed output about the curve
  NoiseModel noise;
  std::vector<std::string> remarks;  // what could not be estimated, and why
};

// Scale factor of one sensor axis: omega = alpha (xi - beta), paper eq. (2).
struct ScaleResult {
  SensorAxis axis = SensorAxis::kZ;
  std::string unit;  // of the output: LSB, deg/s
  std::int64_t turns = 0;
  std::string schedule;  // "stops" (stop to stop) or "continuous" (10 Hz nodes)
  // Joint estimate.
  double alpha = kMissing;            // deg/s per output unit
  double alpha_std_error = kMissing;  // with the reference's own uncertainty, where it is said
  double alpha_statistical_std_error = kMissing;  // of the fit and the time base alone
  // Relative standard uncertainty of the reference in alpha_std_error
  // (calibration/reference_error.h). NaN: nothing is said of it, and alpha is relative to the
  // reference.
  double reference_uncertainty = kMissing;
  double scale_error = kMissing;  // alpha x nominal sensitivity - 1; NaN without a nominal
  double bias = kMissing;         // output units, at bias_temperature_degC
  double bias_std_error = kMissing;
  double alpha_bias_covariance = kMissing;
  double bias_temperature_degC = kMissing;
  double residual_rms_deg = kMissing;
  double whitened_rms = kMissing;
  // The paper's eq. (4), (5): per turn with the rest before each, their mean; and with the first
  // rest only.
  double paper_alpha = kMissing;
  double paper_alpha_std_error = kMissing;
  double paper_first_rest_alpha = kMissing;
  // Validity.
  double min_rate_deg_s = kMissing, max_rate_deg_s = kMissing;
  double min_temperature_degC = kMissing, max_temperature_degC = kMissing;
  // Of the rests alone where their offsets scatter (BiasResult::offset_scatter): the fit's own
  // would take the scatter for a random walk.
  NoiseModel noise;
  bool noise_of_rests = false;
  double tick_ratio = kMissing;  // host seconds per second of the unit's clock
  double tick_ratio_std_error = kMissing;
  std::vector<std::string> remarks;
};

// One analysis of one measurement.
struct AnalysisResult {
  MeasurementInfo info;
  std::int64_t samples = 0;
  std::int64_t reference_samples = 0;
  double first_time_s = 0.0;
  double duration_s = 0.0;
  double gyro_rate_hz = kMissing;  // median
  std::vector<Defect> defects;
  std::vector<BiasResult> bias;
  std::vector<ScaleResult> scale;
  // What an axis of the sensor turned by the reference while its output did not follow at all
  // [deg]; 0 where it did, or did not turn.
  std::array<double, 3> unfollowed_deg = {};
  // What the data show to be wrong with them, and of each axis whose result cannot be, why
  // (plausibility.h). Not part of the JSON.
  std::vector<std::string> faults;
  std::array<std::string, 3> cause;
  // That gyro and reference were not logged by one clock (calibration/signal/clock_offset.h), which
  // is a remark as well; empty where nothing speaks for it. Not part of the JSON.
  std::string two_clocks;
  std::vector<std::string> remarks;
};

}  // namespace gyrobench::calibration
