// The zero-rate offset depends on the square of the specific force.
#include "calibration/effects/basis.h"
#include "calibration/effects/catalogue/makers.h"

namespace gyrobench::calibration {
namespace {

// With g_x^2 + g_y^2 + g_z^2 = 1 the third is a constant.
class GravitySquaredBasis final : public ChannelBasis {
 public:
  using ChannelBasis::ChannelBasis;
  void At(const SensorState& point, double* terms) override {
    terms[0] = point.gravity_g[0] * point.gravity_g[0];
    terms[1] = point.gravity_g[1] * point.gravity_g[1];
  }
};

}  // namespace

Effect BiasGSquared() {
  return {
      .id = "bias.g_squared",
      .equation = "k_x g_x^2 + k_y g_y^2",
      .cause = "electrodes bend under the specific force",
      .looks_like =
          "the zero-rate offset differs from pose to pose, but not when the sensor is turned over",
      .manoeuvre = "hold poses with each axis up and down",
      .needs = kNeedsGravity,
      .terms = {{"k_x", "deg/s/g^2"}, {"k_y", "deg/s/g^2"}},
      .typical_size = 0.02,
      .size_source = "experience with parts of this class; data sheets do not state it",
      .slow = true,
      .c_expression = "({c0} * g[0] * g[0] + {c1} * g[1] * g[1])",
      .basis = Make<GravitySquaredBasis>};
}

}  // namespace gyrobench::calibration
