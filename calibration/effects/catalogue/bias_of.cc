// The zero-rate offset depends on a column of the measurement.
#include "calibration/effects/basis.h"
#include "calibration/effects/catalogue/makers.h"

namespace gyrobench::calibration {
namespace {

class CovariateBasis final : public ChannelBasis {
 public:
  using ChannelBasis::ChannelBasis;
  void At(const SensorState& point, double* terms) override {
    terms[0] = point.covariates[context().covariate] - context().covariate_mean;
  }
};

}  // namespace

Effect BiasOf() {
  return {.id = "bias.of",
          .equation = "c (x - mean)",
          .cause = "whatever moves with the column",
          .looks_like = "the zero-rate offset follows a column of the table, as the supply voltage",
          .manoeuvre = "vary {} while the sensor rests",
          .needs = kNeedsCovariate,
          .terms = {{"c", "deg/s per unit"}},
          .size_source = "it depends on what the column is",
          .slow = true,
          .basis = Make<CovariateBasis>};
}

}  // namespace gyrobench::calibration
