// The scale factor depends on a column of the measurement.
#include "calibration/effects/basis.h"
#include "calibration/effects/catalogue/makers.h"

namespace gyrobench::calibration {
namespace {

class ScaleCovariateBasis final : public ChannelBasis {
 public:
  using ChannelBasis::ChannelBasis;
  void At(const SensorState& point, double* terms) override {
    terms[0] = rate(point) * (point.covariates[context().covariate] - context().covariate_mean);
  }
};

}  // namespace

Effect ScaleOf() {
  return {.id = "scale.of",
          .equation = "c w (x - mean)",
          .cause = "whatever moves with the column",
          .looks_like =
              "the error of a turn is proportional to its angle, by a share that follows a column "
              "of the table",
          .manoeuvre = "vary {} and turn at the same speeds at each value",
          .needs = kNeedsCovariate | kNeedsRate,
          .terms = {{"c", "1 per unit"}},
          .size_source = "it depends on what the column is",
          .basis = Make<ScaleCovariateBasis>};
}

}  // namespace gyrobench::calibration
