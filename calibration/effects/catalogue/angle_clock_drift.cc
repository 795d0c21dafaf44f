// The clocks of gyro and reference part.
#include <cmath>

#include "calibration/effects/basis.h"
#include "calibration/effects/catalogue/makers.h"
#include "calibration/effects/catalogue/shared_bases.h"

namespace gyrobench::calibration {
namespace {

// A delay that grows with time, in millionths of it.
class ClockDriftBasis final : public ChannelBasis {
 public:
  using ChannelBasis::ChannelBasis;
  void At(const SensorState& point, double* terms) override {
    constexpr double kShort_s = 1e-7;
    const double per_ppm_s = 1e-6 * point.t_s;
    const double tau_s = context().nonlinear[0] * per_ppm_s;
    const double by_s = std::fabs(tau_s) > kShort_s ? tau_s : kShort_s;
    terms[0] = -TurnedOn(point, context().channel, by_s) / by_s * per_ppm_s;
  }
};

}  // namespace

Effect AngleClockDrift() {
  return {.id = "angle.clock_drift",
          .domain = EffectDomain::kAngle,
          .owner = EffectOwner::kBench,
          .equation = "-eps t w",
          .cause = "two clocks that part",
          .looks_like =
              "the angle errs in proportion to the speed while the table turns, the more the "
              "longer the run lasts",
          .manoeuvre = "repeat a motion after 30 min",
          .needs = kNeedsRate,
          .terms = {{"eps", "ppm"}},
          .nonlinear = {{"eps", "ppm", -1000.0, 1000.0, {0.0}}},
          .search = Search::kCoefficient,
          .typical_size = 100.0,
          .size_source = "crystals: 10 to 100 ppm",
          .basis = Make<ClockDriftBasis>};
}

}  // namespace gyrobench::calibration
