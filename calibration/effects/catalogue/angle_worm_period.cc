// An error that repeats with the turn of the shaft.
#include "calibration/effects/basis.h"
#include "calibration/effects/catalogue/makers.h"
#include "calibration/effects/catalogue/shared_bases.h"

namespace gyrobench::calibration {
namespace {

class ShaftPeriodBasis final : public PeriodicBasis {
 public:
  using PeriodicBasis::PeriodicBasis;

 private:
  double periods() const override { return context().nonlinear[0] * context().gear_ratio; }
};

// Met at evenly spaced angles, rounding leaves waves of many periods a turn that are as large.
constexpr double kRoundingInWave = 0.25;

}  // namespace

Effect AngleWormPeriod() {
  return {.id = "angle.worm_period",
          .domain = EffectDomain::kAngle,
          .owner = EffectOwner::kBench,
          .equation = "a sin(psi) + b cos(psi), psi the shaft's angle",
          .cause = "eccentric worm",
          .looks_like =
              "the angle errs by a wave once or twice in a turn of the shaft (9 deg of a table "
              "with a gear of 40)",
          .manoeuvre = "turn slowly by parts of a shaft turn, finely sampled",
          .needs = kNeedsRate | kNeedsTableAxis | kNeedsGear,
          .terms = {{"a", "deg"}, {"b", "deg"}},
          .nonlinear = {{"harmonic", "1/turn", 0.0, 0.0, {1.0, 2.0}}},
          .search = Search::kEachPoint,
          .typical_size = 0.025,
          .size_source =
              "taken to be no larger than the error of a stop that is stated for such stands, "
              "0.025 deg",
          .made_by_rounding = kRoundingInWave,
          .wave_of_angle = true,
          .of_each_reading = true,
          .basis = Make<ShaftPeriodBasis>};
}

}  // namespace gyrobench::calibration
