// Fit of the host's clock against a sensor unit's tick.
#pragma once

#include <cstdint>

#include "base/measurement.h"

namespace gyrobench {

// Exponentially forgetting least-squares line through pairs of ticks and host times:
//   host_s = host_0 + ratio * (tick_s - tick_0)
// O(1) in time and memory. With memory_s = infinity it is the ordinary least-squares line.
class TickFit {
 public:
  // `memory_s`: age at which a pair's weight has fallen to 1/e.
  explicit TickFit(double memory_s = std::numeric_limits<double>::infinity());
  // A tick that goes back is that of a unit that began anew.
  void Add(const TickPair& pair);
  // The unit's tick begins again: what follows lies on another line, of the same ratio. All lines
  // together say what it is; HostTime is that of the newest.
  void BeginAnew() { weight_ = mean_tick_ = mean_offset_ = 0.0; }
  std::int64_t count() const { return count_; }
  // Host time of a tick by the line so far. With no pair: NaN; with one: ratio 1.
  double HostTime(double tick_s) const;
  // Host seconds per unit second: 1 / (rate of the unit's clock relative to nominal). NaN with
  // fewer than 2 pairs.
  double ratio() const;
  // Standard error of ratio() from the residuals' scatter. NaN with fewer than 3 pairs or with
  // forgetting (where pairs weigh unequally the formula does not hold).
  double ratio_std_error() const;
  // Root mean square of host time about the line [s]. NaN with fewer than 3 pairs.
  double residual_rms_s() const;

 private:
  double memory_s_;
  std::int64_t count_ = 0, lines_ = 0;
  double weight_ = 0.0, all_weight_ = 0.0;  // of the newest line, of all
  // Weighted means and central moments, relative to the first pair of a line so that nothing cancels.
  // The moments are sums over all lines, each about its own means.
  double tick0_ = 0.0, host0_ = 0.0, last_tick_ = 0.0;
  double mean_tick_ = 0.0, mean_offset_ = 0.0;  // offset = (host - host0) - (tick - tick0)
  double s_tt_ = 0.0, s_to_ = 0.0, s_oo_ = 0.0;
};

}  // namespace gyrobench
