// The gyro is late against the reference.
#include <cmath>

#include "calibration/effects/basis.h"
#include "calibration/effects/catalogue/makers.h"
#include "calibration/effects/catalogue/shared_bases.h"

namespace gyrobench::calibration {
namespace {

// z(t) = Phi(t - tau), so that the reference has turned on by what the gyro will see within tau.
// Linear in tau only as long as the rate is constant.
class LatencyBasis final : public ChannelBasis {
 public:
  using ChannelBasis::ChannelBasis;
  void At(const SensorState& point, double* terms) override {
    constexpr double kShort_s = 1e-5;
    const double tau_s = context().nonlinear[0];
    const double by_s = std::fabs(tau_s) > kShort_s ? tau_s : kShort_s;
    terms[0] = -TurnedOn(point, context().channel, by_s) / by_s;
  }
};

}  // namespace

Effect AngleLatency() {
  return {.id = "angle.latency",
          .domain = EffectDomain::kAngle,
          .owner = EffectOwner::kBench,
          .equation = "-tau w",
          .cause = "delay of the bus or the filter; negative: of the encoder",
          .looks_like =
              "the angle errs in proportion to the speed while the table turns, and not at rest",
          .manoeuvre = "accelerate, reverse, or swing in a sine",
          .needs = kNeedsRate,
          .terms = {{"tau", "s"}},
          .nonlinear = {{"tau", "s", -0.2, 0.2, {0.0}}},
          .search = Search::kCoefficient,
          .typical_size = 0.02,
          .size_source = "experience with buses and filters of this class: 1 to 20 ms",
          .filter_shape = true,
          .basis = Make<LatencyBasis>};
}

}  // namespace gyrobench::calibration
