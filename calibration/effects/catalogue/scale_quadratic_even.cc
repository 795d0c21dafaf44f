// Nonlinearity without the sign of the rate.
#include "calibration/effects/basis.h"
#include "calibration/effects/catalogue/makers.h"
#include "calibration/effects/catalogue/shared_bases.h"

namespace gyrobench::calibration {
namespace {

double Square(double rate_deg_s) { return rate_deg_s * rate_deg_s; }

}  // namespace

Effect ScaleQuadraticEven() {
  return {.id = "scale.quadratic_even",
          .equation = "c w^2",
          .cause = "nonlinearity of electrodes or converter",
          .looks_like =
              "turns there and back do not close, by an error that grows with the speed at the "
              "same angle",
          .manoeuvre = "turn at several speeds both ways",
          .needs = kNeedsRate,
          .terms = {{"c", "1/(deg/s)"}},
          .typical_size = 2.5e-5,
          .size_source = "experience with parts of this class: 0.01 to 0.1 % at 40 deg/s",
          .c_expression = "{c0} * {w} * {w}",
          .basis = Make<RateBasis<Square>>};
}

}  // namespace gyrobench::calibration
