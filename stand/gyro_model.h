// What the gyro chip makes of the truth: the deterministic part of its output.
#pragma once

#include "config/scenario.h"
#include "stand/thermal.h"

namespace gyrobench::stand {

using config::Square;
using config::Triple;

// The state of the world at a sample, frame S.
struct GyroInput {
  Triple rate_deg_s = {};  // after the filter
  Triple g = {};
  double t_s = 0.0;  // since power-on
  double die_degC = 25.0;
  double die_rate_degC_s = 0.0;
  double vibration_g2 = 0.0;
};

// xi / s0 = M w + terms in w + b(T) + terms in g, T, t; one line a term in gyro_model.cc, written
// from the convention of the scenario (config/scenario.h). Keeps a reference to the scenario.
class GyroModel {
 public:
  explicit GyroModel(const config::GyroScenario& scenario);
  // Output in deg/s. Samples in the order of time: the hysteresis remembers.
  Triple Output(const GyroInput& input);

 private:
  void AddRateTerms(const GyroInput& in, Triple& out) const;
  void AddGravityTerms(const GyroInput& in, Triple& out) const;
  void AddThermalTerms(const GyroInput& in, Triple& out);
  void AddTimeTerms(const GyroInput& in, Triple& out) const;

  const config::GyroScenario& scenario_;
  Square m_;
  // Terms that are all zero are left out.
  bool has_nonlinearity_, has_scale_g_, has_g_temperature_, has_g_squared_, has_thermal_extras_,
      has_warm_up_, has_vibration_;
  bool hysteresis_begun_ = false;
  double hysteresis_follower_degC_ = 0.0;
};

}  // namespace gyrobench::stand
