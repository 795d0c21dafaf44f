// The choice of a run's next manoeuvre: rehearsals of the engine as the analysis takes them.
#pragma once

#include <vector>

#include "calibration/plan/loop_memory.h"
#include "calibration/trace/trace.h"
#include "procedures/engine/bench.h"

namespace gyrobench::daemon {

// `small_below`: as ChooseManoeuvre has it. `traced`: of `so_far`. `memory`: one for each run.
// Throws DataError where the reference is not that of a stand.
procedures::Choice ChooseAmong(const std::vector<procedures::Rehearsal>& menu, double small_below,
                               const calibration::Recording& so_far,
                               const calibration::Traced& traced, calibration::LoopMemory& memory);

}  // namespace gyrobench::daemon
