// Nonlinearity with the sign of the rate.
#include <cmath>

#include "calibration/effects/basis.h"
#include "calibration/effects/catalogue/makers.h"
#include "calibration/effects/catalogue/shared_bases.h"

namespace gyrobench::calibration {
namespace {

double OddSquare(double rate_deg_s) { return rate_deg_s * std::fabs(rate_deg_s); }

}  // namespace

Effect ScaleQuadraticOdd() {
  return {.id = "scale.quadratic_odd",
          .equation = "c w |w|",
          .cause = "nonlinearity of electrodes or converter",
          .looks_like =
              "the scale factor grows or falls in proportion to the speed, the same way in both "
              "directions",
          .manoeuvre = "turn at six speeds and more, up to half the range",
          .needs = kNeedsRate,
          .terms = {{"c", "1/(deg/s)"}},
          .typical_size = 5e-5,
          .size_source =
              "0.2 % of the rate at 40 deg/s; 0.2 % is the typical nonlinearity of the MPU-6050 "
              "data sheet 3.4, section 6.1",
          .c_expression = "{c0} * {w} * GYROBENCH_SIZE({w})",
          .basis = Make<RateBasis<OddSquare>>};
}

}  // namespace gyrobench::calibration
