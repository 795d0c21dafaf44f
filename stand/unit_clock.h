// The microcontroller's tick.
#pragma once

#include <cmath>
#include <cstdint>

#include "config/scenario.h"

namespace gyrobench::stand {

// Ticks since boot, at a rate that is nominal (1 + error + temperature + drift). Between two
// samples the rate stands still, so that ticks never jump. Keeps a reference to the scenario.
class UnitClock {
 public:
  UnitClock(const config::UnitScenario& scenario, double nominal_hz)
      : scenario_(scenario), nominal_hz_(nominal_hz), rate_hz_(nominal_hz) {}

  void Restart(double t_s) {
    t_s_ = t_s;
    ticks_ = 0.0;
  }
  // Leaps ahead by `s`, or back.
  void Jump(double s) { ticks_ += s * rate_hz_; }
  // To the time of a sample, at which the package has `degC`.
  void Advance(double t_s, double degC) {
    ticks_ += (t_s - t_s_) * rate_hz_;
    t_s_ = t_s;
    rate_hz_ =
        nominal_hz_ * (1.0 + scenario_.tick_rel + scenario_.tick_rel_per_degC * (degC - 25.0) +
                       scenario_.tick_drift_rel_per_h * t_s / 3600.0);
  }
  // Wrapped at 32 bits, as the unit counts.
  std::uint32_t TickAt(double t_s) const {
    const double ticks = std::floor(ticks_ + (t_s - t_s_) * rate_hz_);
    return static_cast<std::uint32_t>(static_cast<std::int64_t>(ticks));
  }

 private:
  const config::UnitScenario& scenario_;
  double nominal_hz_;
  double rate_hz_;
  double t_s_ = 0.0;
  double ticks_ = 0.0;
};

}  // namespace gyrobench::stand
