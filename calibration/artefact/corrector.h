// A calibration applied: from the sensor's output to its rate, by the sensor's own columns alone.
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "base/geometry.h"
#include "base/measurement.h"
#include "calibration/artefact/calibration_file.h"

namespace gyrobench::calibration {

// What happened to one axis.
struct ChannelCorrection {
  SensorAxis axis = SensorAxis::kZ;
  bool calibrated = false;  // else: divided by the nominal sensitivity
  std::int64_t corrected = 0;
  std::int64_t missing = 0;   // no value in, none out
  std::int64_t unsolved = 0;  // the model has no solution there: none out
  // Corrected outside of what the calibration saw, with what it says at the edge of that.
  std::int64_t beyond_rate = 0, beyond_temperature = 0;
  double largest_rate_deg_s = 0.0;  // of those beyond, either sign
  double lowest_degC = kMissing, highest_degC = kMissing;
  // The edges, NaN where the calibration knows none.
  double max_rate_deg_s = kMissing, min_temperature_degC = kMissing,
         max_temperature_degC = kMissing;
};

struct CorrectionReport {
  std::int64_t samples = 0;  // with a value of at least one axis
  std::int64_t outside = 0;  // samples with an axis beyond its rates or temperatures
  std::vector<ChannelCorrection> channels;
  std::vector<std::string> remarks;  // effects that were not applied, and why
};

struct CorrectorOptions {
  bool any_sensor = false;  // also where the serial numbers differ
};

// Solves, for the rates w of all axes that have a value at that time together,
//   xi_c / s0 = sum_j M_cj w_j + sum_k b_k (T - T0)^k + sum of the gyro's rate effects(state, w)
// by  w <- M^-1 (xi / s0 - b - effects(w)),  which converges while the effects are small beside w.
// xi is a count less the zero that the calibration was made with (trace/zero_match.h).
// An axis without a value has the rate that it had last, one that is not there at all 0. An axis
// whose effects have no solution takes part without them, and has no value.
//
// A polynomial says nothing beyond the data that it was fitted to, and a cubic one folds there. So
// temperatures enter bias and effects as the nearest within the channel's range, and rates, where
// an effect is not a straight line in them, as well; M and effects straight in the rate go on.
//
// The state comes from the samples: gravity from the accelerometer, temperature, further columns
// (trace/slow_state.h). Effects whose state is not there are left out and said in the remarks.
class Corrector {
 public:
  // Throws DataError where this calibration cannot be of these data: unit, nominal sensitivity,
  // serial number, no axis in common, a matrix that has no inverse.
  Corrector(const Calibration& calibration, const MeasurementInfo& info,
            const CorrectorOptions& options = {});
  ~Corrector();
  Corrector(const Corrector&) = delete;
  Corrector& operator=(const Corrector&) = delete;

  // Takes a sample, in the order of time. Every sample comes out again, some 5 s of data later.
  void Add(const GyroSample& sample, std::span<const double> covariates);
  // No more samples: all come out. Throws DataError where their counts are those of a signed word
  // that was written as an unsigned one.
  void End();
  // The next corrected sample: rates in deg/s, frame S; NaN where there is none. False when more
  // input is needed.
  bool Next(Vector3* rate_deg_s);

  CorrectionReport Report() const;

 private:
  class Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace gyrobench::calibration
