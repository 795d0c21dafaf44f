// The disc of the encoder is off centre, or oval.
#include <string>

#include "calibration/effects/basis.h"
#include "calibration/effects/catalogue/makers.h"
#include "calibration/effects/catalogue/shared_bases.h"

namespace gyrobench::calibration {
namespace {

template <int kPeriods>
class TablePeriodBasis final : public PeriodicBasis {
 public:
  using PeriodicBasis::PeriodicBasis;

 private:
  double periods() const override { return kPeriods; }
};

template <int kPeriods>
Effect Eccentricity(const std::string& id, const std::string& equation, const std::string& cause,
                    const std::string& looks_like) {
  return {.id = id,
          .domain = EffectDomain::kAngle,
          .owner = EffectOwner::kReference,
          .equation = equation,
          .cause = cause,
          .looks_like = looks_like,
          .manoeuvre = "turn by 360 deg and more",
          .needs = kNeedsRate | kNeedsTableAxis,
          .terms = {{"a", "deg"}, {"b", "deg"}},
          .typical_size = 0.05,
          .size_source = "experience with encoders of this class: 0.003 to 0.05",
          .wave_of_angle = true,
          .reference_eccentricity = true,
          .basis = Make<TablePeriodBasis<kPeriods>>};
}

}  // namespace

Effect AngleEccentricity1() {
  return Eccentricity<1>("angle.eccentricity_1", "a sin(phi) + b cos(phi)",
                         "the encoder's disc is off centre",
                         "the angle errs by a wave once in a turn of the table");
}

Effect AngleEccentricity2() {
  return Eccentricity<2>("angle.eccentricity_2", "a sin(2 phi) + b cos(2 phi)",
                         "the encoder's disc is off centre or oval",
                         "the angle errs by a wave twice in a turn of the table");
}

}  // namespace gyrobench::calibration
