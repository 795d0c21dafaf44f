// The zero-rate offset jumps.
#include "calibration/effects/basis.h"
#include "calibration/effects/catalogue/makers.h"

namespace gyrobench::calibration {
namespace {

class BiasStepBasis final : public ChannelBasis {
 public:
  using ChannelBasis::ChannelBasis;
  void At(const TrackPoint& point, double* terms) override {
    terms[0] = point.t_s >= context().nonlinear[0] ? 1.0 : 0.0;
  }
};

}  // namespace

Effect BiasStep() {
  return {.id = "bias.step",
          .equation = "b 1(t >= t0)",
          .cause = "stress, supply or a restart",
          .looks_like = "the zero-rate offset changes at one moment and stays changed",
          .manoeuvre = "none: it is found where it happens",
          .terms = {{"b", "deg/s"}},
          .nonlinear = {{"t0", "s"}},
          .search = Search::kTime,
          .typical_size = 0.5,
          .size_source = "experience with parts of this class: 0.01 to 0.5",
          .slow = true,
          .basis = Make<BiasStepBasis>};
}

}  // namespace gyrobench::calibration
