// Nonlinearity of third order.
#include "calibration/effects/basis.h"
#include "calibration/effects/catalogue/makers.h"
#include "calibration/effects/catalogue/shared_bases.h"

namespace gyrobench::calibration {
namespace {

double Cube(double rate_deg_s) { return rate_deg_s * rate_deg_s * rate_deg_s; }

}  // namespace

Effect ScaleCubic() {
  return {.id = "scale.cubic",
          .equation = "c w^3",
          .cause = "nonlinearity of electrodes or converter",
          .looks_like =
              "the scale factor grows or falls with the square of the speed, the same way in both "
              "directions",
          .manoeuvre = "turn at six speeds and more, up to half the range",
          .needs = kNeedsRate,
          .terms = {{"c", "1/(deg/s)^2"}},
          .typical_size = 1e-6,
          .size_source =
              "0.2 % of the rate at 40 deg/s; 0.2 % is the typical nonlinearity of the MPU-6050 "
              "data sheet 3.4, section 6.1",
          .c_expression = "{c0} * {w} * {w} * {w}",
          .basis = Make<RateBasis<Cube>>};
}

}  // namespace gyrobench::calibration
