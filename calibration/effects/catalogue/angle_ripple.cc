// An error that repeats many times in a turn of the table.
#include "calibration/effects/basis.h"
#include "calibration/effects/catalogue/makers.h"
#include "calibration/effects/catalogue/shared_bases.h"

namespace gyrobench::calibration {
namespace {

class RippleBasis final : public PeriodicBasis {
 public:
  using PeriodicBasis::PeriodicBasis;

 private:
  double periods() const override { return context().nonlinear[0]; }
};

}  // namespace

Effect AngleRipple() {
  return {.id = "angle.ripple",
          .domain = EffectDomain::kAngle,
          .owner = EffectOwner::kBench,
          .equation = "a sin(k phi) + b cos(k phi)",
          .cause = "steps of the motor, teeth of a gear, or lines of the encoder",
          .looks_like = "the angle errs by a wave a whole number of times in a turn of the table",
          .manoeuvre = "turn at constant speed, slowly",
          .needs = kNeedsRate | kNeedsTableAxis,
          .terms = {{"a", "deg"}, {"b", "deg"}},
          .nonlinear = {{"k", "1/turn"}},
          .search = Search::kPeriods,
          .typical_size = 0.5,
          .size_source = "experience with stands of this class: 0.001 to 0.5",
          .of_each_reading = true,
          .basis = Make<RippleBasis>};
}

}  // namespace gyrobench::calibration
