// The reference angle sensor of one axis.
#pragma once

#include <cstdint>

#include "config/scenario.h"
#include "config/stand_config.h"
#include "stand/mechanics.h"

namespace gyrobench::stand {

// phi = angle of the table (or of the shaft over the ratio), `latency` ago, psi = shaft angle:
//   reading = phi (1 + scale) + e1 sin(phi+p1) + e2 sin(2 phi+p2) + r sin(k phi+p) + worm terms in
//   psi
//           + zero + step + noise          [deg], then counted with the sign and offset of the
//           stand file.
// The sensor computes a new value every refresh_s and repeats it in between; the noise belongs to
// the value, not to the reading, so it does not matter who reads how often.
class AngleEncoder {
 public:
  AngleEncoder(const config::EncoderScenario& scenario, const config::EncoderConfig& config,
               double gear_ratio, std::uint64_t source_seed);
  // In 0 .. range_counts - 1. It reads high by `jump_deg`.
  std::uint32_t Counts(double t_s, const AxisMechanics& axis, double jump_deg = 0.0) const;
  // Before counting, in degrees of the stand's convention.
  double Reading_deg(double t_s, const AxisMechanics& axis) const;

 private:
  config::EncoderScenario scenario_;
  double sign_, offset_deg_, counts_per_deg_;
  std::int64_t range_counts_;
  double gear_ratio_;
  std::uint64_t source_seed_;
};

}  // namespace gyrobench::stand
