// The gyro is late against the reference.
#include "calibration/effects/catalogue/makers.h"
#include "calibration/effects/catalogue/shared_bases.h"
#include "calibration/signal/clock_offset.h"

namespace gyrobench::calibration {
namespace {

double Latency_s(double tau_s, double) { return tau_s; }

}  // namespace

Effect AngleLatency() {
  return {.id = "angle.latency",
          .domain = EffectDomain::kAngle,
          .owner = EffectOwner::kBench,
          .equation = "-tau w",
          .cause =
              "positive: the gyro is late, by its bus or filter; negative: the reference is late, "
              "by its encoder",
          .looks_like =
              "the angle errs in proportion to the speed while the table turns, and not at rest",
          .manoeuvre = "accelerate, reverse, or swing in a sine",
          .needs = kNeedsRate,
          .terms = {{"tau", "s"}},
          .nonlinear = {{"tau", "s", -kLargestLatency_s, kLargestLatency_s, {0.0}}},
          .search = Search::kCoefficient,
          .typical_size = 0.02,
          .size_source = "experience with buses and filters of this class: 1 to 20 ms",
          .filter_shape = true,
          .delay_s = Latency_s,
          .basis = Make<DelayBasis<Latency_s>>};
}

}  // namespace gyrobench::calibration
