// Another scale factor for each sign of the rate.
#include <cmath>

#include "calibration/effects/basis.h"
#include "calibration/effects/catalogue/makers.h"
#include "calibration/effects/catalogue/shared_bases.h"

namespace gyrobench::calibration {
namespace {

double Size(double rate_deg_s) { return std::fabs(rate_deg_s); }

}  // namespace

Effect ScaleAsymmetry() {
  return {.id = "scale.asymmetry",
          .equation = "c |w|",
          .cause = "another gain for each sign of the rate",
          .looks_like =
              "turns there and back do not close, by a share of their angle that is the same at "
              "every speed",
          .manoeuvre = "turn at the same speeds both ways",
          .needs = kNeedsRate,
          .terms = {{"c", "1"}},
          .typical_size = 1e-3,
          .size_source = "experience with parts of this class: 0.01 to 0.1 %",
          .c_expression = "{c0} * GYROBENCH_SIZE({w})",
          .basis = Make<RateBasis<Size>>};
}

}  // namespace gyrobench::calibration
