// The zero-rate offset settles after power-on.
#include <cmath>

#include "calibration/effects/basis.h"
#include "calibration/effects/catalogue/makers.h"

namespace gyrobench::calibration {
namespace {

class WarmUpBasis final : public ChannelBasis {
 public:
  using ChannelBasis::ChannelBasis;
  void At(const SensorState& point, double* terms) override {
    terms[0] = std::exp(-point.since_power_on_s / context().nonlinear[0]);
  }
};

}  // namespace

Effect BiasWarmUp() {
  return {
      .id = "bias.warm_up",
      .equation = "A exp(-t/tau), t since power-on",
      .cause = "self-heating after power-on",
      .looks_like =
          "the zero-rate offset settles within minutes of power-on, whatever the temperature does",
      .manoeuvre = "start twice, from different temperatures",
      .needs = kNeedsPowerOn,
      .terms = {{"A", "deg/s"}},
      .nonlinear = {{"tau", "s", 5.0, 600.0, {15, 30, 60, 100, 170, 300, 550}}},
      .search = Search::kGrid,
      .typical_size = 0.3,
      .size_source = "experience with parts of this class: 0.01 to 0.3",
      .slow = true,
      .c_expression = "{c0} * GYROBENCH_EXP({minus_1_over_n0} * in->since_power_on_s)",
      .basis = Make<WarmUpBasis>};
}

}  // namespace gyrobench::calibration
