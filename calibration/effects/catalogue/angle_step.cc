// The angle jumps.
#include <algorithm>

#include "calibration/effects/basis.h"
#include "calibration/effects/catalogue/makers.h"

namespace gyrobench::calibration {
namespace {

// The mean over what a point stands for.
class AngleStepBasis final : public ChannelBasis {
 public:
  using ChannelBasis::ChannelBasis;
  void At(const SensorState& point, double* terms) override {
    const double since_s = point.t_s - context().nonlinear[0], span_s = point.span_s();
    terms[0] = span_s > 0.0 ? std::clamp(0.5 + since_s / span_s, 0.0, 1.0)
                            : static_cast<double>(since_s >= 0.0);
  }
};

// An angle that is rounded up before and down after: a whole step of the encoder, and some noise.
constexpr double kRoundingInStep = 2.4;

}  // namespace

Effect AngleStep() {
  return {.id = "angle.step",
          .domain = EffectDomain::kAngle,
          .owner = EffectOwner::kReference,
          .equation = "b 1(t >= t0)",
          .cause = "a lost or doubled sample, lost steps, a slipped reference",
          .looks_like = "the angle is off by the same amount from one moment of a motion on",
          .manoeuvre = "check the counters of samples and steps",
          .needs = kNeedsRate | kNeedsTableAxis,
          .terms = {{"b", "deg"}},
          .nonlinear = {{"t0", "s"}},
          .search = Search::kTime,
          .typical_size = 0.5,
          .size_source = "experience with stands of this class: 0.01 to 0.5",
          .may_be_larger = true,
          .made_by_rounding = kRoundingInStep,
          .of_each_reading = true,
          .basis = Make<AngleStepBasis>};
}

}  // namespace gyrobench::calibration
