// The stand of the stand file as a procedure sees it.
#pragma once

#include "config/stand_config.h"
#include "procedures/engine/bench.h"

namespace gyrobench::daemon {

inline procedures::AxisFacts FactsOf(const config::AxisConfig& axis, double angle_deg) {
  return {axis.name,
          axis.gear_ratio,
          angle_deg,
          axis.min_deg,
          axis.max_deg,
          axis.max_rate_deg_s,
          axis.max_acceleration_deg_s2};
}

}  // namespace gyrobench::daemon
