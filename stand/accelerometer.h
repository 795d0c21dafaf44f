// The accelerometer next to the gyro.
#pragma once

#include <cmath>

#include "config/scenario.h"
#include "stand/random.h"

namespace gyrobench::stand {

//   f = (I + scale + cross) g + offset + offset_T (T - 25 degC) + noise       [g]
// Keeps a reference to the scenario.
class Accelerometer {
 public:
  Accelerometer(const config::AccelerometerScenario& scenario, std::uint64_t seed)
      : scenario_(scenario), noise_(seed, Source::kAccelerometer) {}

  config::Triple Output(const config::Triple& g, double die_degC, double period_s) {
    config::Triple f;
    const double root_rate = 1.0 / std::sqrt(period_s);
    for (std::size_t i = 0; i < 3; ++i) {
      const double* cross = &scenario_.cross_axis_rel[3 * i];
      f[i] = (1.0 + scenario_.scale_rel[i]) * g[i] + cross[0] * g[0] + cross[1] * g[1] +
             cross[2] * g[2] + scenario_.offset_g[i] +
             scenario_.offset_g_per_degC[i] * (die_degC - 25.0) +
             scenario_.noise_g_sqrt_s[i] * root_rate * noise_.Normal();
    }
    return f;
  }

 private:
  const config::AccelerometerScenario& scenario_;
  RandomStream noise_;
};

}  // namespace gyrobench::stand
