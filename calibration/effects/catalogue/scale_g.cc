// The scale factor depends on the specific force.
#include "calibration/effects/basis.h"
#include "calibration/effects/catalogue/makers.h"

namespace gyrobench::calibration {
namespace {

class ScaleGravityBasis final : public ChannelBasis {
 public:
  using ChannelBasis::ChannelBasis;
  void At(const SensorState& point, double* terms) override {
    for (std::size_t i = 0; i < 3; ++i) terms[i] = point.gravity_g[i] * rate(point);
  }
};

}  // namespace

Effect ScaleG() {
  return {.id = "scale.g",
          .equation = "(c_x g_x + c_y g_y + c_z g_z) w",
          .cause = "the electrodes' gap, and with it the gain, changes with the specific force",
          .looks_like =
              "the error of a turn is proportional to its angle, by another share in each pose",
          .manoeuvre = "turn at the same speeds with the axis up, down and horizontal",
          .needs = kNeedsGravity | kNeedsRate,
          .terms = {{"c_x", "1/g"}, {"c_y", "1/g"}, {"c_z", "1/g"}},
          .typical_size = 1e-3,
          .size_source = "experience with parts of this class: 0.01 to 0.1 % per g",
          .c_expression = "({c0} * g[0] + {c1} * g[1] + {c2} * g[2]) * {w}",
          .basis = Make<ScaleGravityBasis>};
}

}  // namespace gyrobench::calibration
