// What a bench tells a procedure beside its devices: the axes of the stand file, and the choice of
// the next manoeuvre, for which the engine's rehearsals become those of the analysis.
#pragma once

#include <string>
#include <vector>

#include "calibration/plan/next_manoeuvre.h"
#include "calibration/trace/trace.h"
#include "config/stand_config.h"
#include "daemon/acquisition.h"
#include "procedures/engine/bench.h"

namespace gyrobench::daemon {

// `small_below`: as ChooseManoeuvre has it. `traced`: of `so_far`. `memory`: one for each run.
// Throws DataError where the reference is not that of a stand.
procedures::Choice ChooseAmong(const std::vector<procedures::Rehearsal>& menu, double small_below,
                               const calibration::Recording& so_far,
                               const calibration::Traced& traced, calibration::LoopMemory& memory);

// Of the axis of this name. Throws LimitError where the stand has none.
const config::AxisConfig& ConfigOf(const config::StandConfig& stand, const std::string& name);

inline procedures::AxisFacts FactsOf(const config::AxisConfig& axis, double angle_deg) {
  return {axis.name,
          axis.gear_ratio,
          angle_deg,
          axis.min_deg,
          axis.max_deg,
          axis.max_rate_deg_s,
          axis.max_acceleration_deg_s2};
}

// How axes and outputs are, a line each: "axis.inner: at 12.345 deg, at rest", "heater: off".
std::vector<std::string> HowItIs(const Acquisition& acquisition);

}  // namespace gyrobench::daemon
