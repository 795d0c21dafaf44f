// The zero-rate offset jumps.
#include <algorithm>

#include "calibration/effects/basis.h"
#include "calibration/effects/catalogue/makers.h"

namespace gyrobench::calibration {
namespace {

// The mean over what a point stands for.
class BiasStepBasis final : public ChannelBasis {
 public:
  using ChannelBasis::ChannelBasis;
  void At(const SensorState& point, double* terms) override {
    const double since_s = point.t_s - context().nonlinear[0];
    terms[0] = point.length_s > 0.0 ? std::clamp(0.5 + since_s / point.length_s, 0.0, 1.0)
                                    : static_cast<double>(since_s >= 0.0);
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
