// The gyro follows through a lag of first order.
#include "calibration/effects/basis.h"
#include "calibration/effects/catalogue/makers.h"
#include "calibration/effects/catalogue/shared_bases.h"
#include "calibration/signal/columns.h"

namespace gyrobench::calibration {
namespace {

// Behind a lag 1/(1 + s tau) the gyro shows v with w = v + tau dv/dt: its angle stays behind by
// tau v, at the rate v that it shows.
class LagBasis final : public ChannelBasis {
 public:
  using ChannelBasis::ChannelBasis;
  void At(const SensorState& point, double* terms) override {
    constexpr double kStep_s = 0.5 * kNearStep_s;
    terms[0] = -(TurnedOn(point, context().channel, kStep_s) -
                 TurnedOn(point, context().channel, -kStep_s)) /
               (2.0 * kStep_s);
  }
};

}  // namespace

// A pure delay is the simpler cause of the same: hence the complexity penalty.
Effect BandwidthFirstOrder() {
  return {.id = "bandwidth.first_order",
          .domain = EffectDomain::kAngle,
          .owner = EffectOwner::kGyro,
          .equation = "-tau v, v the rate behind a lag 1 / (1 + s tau)",
          .cause = "the gyro's filter or its mechanics",
          .looks_like =
              "the angle errs in proportion to the speed while the table turns, and settles after "
              "each change of it",
          .manoeuvre = "swing in a sine up to 0.3 of the bandwidth",
          .needs = kNeedsRate,
          .terms = {{"tau", "s"}},
          .typical_size = 0.02,
          .size_source = "filters of this class: 2 to 20 ms",
          .positive = true,
          .complexity_penalty = 10.0,
          .filter_shape = true,
          .basis = Make<LagBasis>};
}

}  // namespace gyrobench::calibration
