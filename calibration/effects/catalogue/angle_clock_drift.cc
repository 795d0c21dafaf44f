// The clocks of gyro and reference part.
#include "calibration/effects/catalogue/makers.h"
#include "calibration/effects/catalogue/shared_bases.h"
#include "calibration/signal/clock_drift.h"

namespace gyrobench::calibration {
namespace {

// A delay that grows with time, in millionths of it.
double DriftedApart_s(double eps_ppm, double t_s) { return 1e-6 * eps_ppm * t_s; }

}  // namespace

Effect AngleClockDrift() {
  return {.id = "angle.clock_drift",
          .domain = EffectDomain::kAngle,
          .owner = EffectOwner::kBench,
          .equation = "-eps t w",
          .cause = "two clocks that part; positive: the gyro's is the faster",
          .looks_like =
              "the angle errs in proportion to the speed while the table turns, the more the "
              "longer the run lasts",
          .manoeuvre = "repeat a motion after 30 min",
          .needs = kNeedsRate,
          .terms = {{"eps", "ppm"}},
          .nonlinear = {{"eps", "ppm", -kMostDrift_ppm, kMostDrift_ppm, {0.0}}},
          .search = Search::kCoefficient,
          .typical_size = 100.0,
          .size_source = "crystals: 10 to 100 ppm",
          .delay_s = DriftedApart_s,
          .delay_of_clocks = true,
          .basis = Make<DelayBasis<DriftedApart_s>>};
}

}  // namespace gyrobench::calibration
