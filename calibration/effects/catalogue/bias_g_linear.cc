// The zero-rate offset depends on the specific force: g-sensitivity.
#include "calibration/effects/basis.h"
#include "calibration/effects/catalogue/makers.h"

namespace gyrobench::calibration {
namespace {

constexpr const char* kGLinear = "bias.g_linear";

class GravityBasis final : public ChannelBasis {
 public:
  using ChannelBasis::ChannelBasis;
  void At(const SensorState& point, double* terms) override {
    for (std::size_t i = 0; i < 3; ++i) terms[i] = point.gravity_g[i];
  }
};

}  // namespace

Effect BiasGLinear() {
  return {.id = kGLinear,
          .equation = "k . g",
          .cause = "mass unbalance of the element, shift of its quadrature error",
          .looks_like =
              "the zero-rate offset differs from pose to pose, and its shift changes sign when the "
              "sensor is turned over",
          .manoeuvre = "hold six poses, or turn about a horizontal axis",
          .needs = kNeedsGravity,
          .terms = {{"k_x", "deg/s/g"}, {"k_y", "deg/s/g"}, {"k_z", "deg/s/g"}},
          .typical_size = 0.1,
          .size_source =
              "MPU-6050 data sheet 3.4, section 6.1: typical sensitivity to linear acceleration",
          .slow = true,
          .c_expression = "({c0} * g[0] + {c1} * g[1] + {c2} * g[2])",
          .basis = Make<GravityBasis>};
}

const Effect& GSensitivityEffect() {
  static const Effect& effect = *FindEffect(kGLinear);
  return effect;
}

}  // namespace gyrobench::calibration
