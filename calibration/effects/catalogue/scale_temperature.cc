// The scale factor depends on the temperature.
#include "calibration/effects/basis.h"
#include "calibration/effects/catalogue/makers.h"

namespace gyrobench::calibration {
namespace {

class ScaleTemperatureBasis final : public ChannelBasis {
 public:
  using ChannelBasis::ChannelBasis;
  void At(const SensorState& point, double* terms) override {
    terms[0] = rate(point) * (point.temperature_degC - context().reference_degC);
  }
};

}  // namespace

Effect ScaleTemperature() {
  return {.id = "scale.temperature",
          .equation = "c w (T - T0)",
          .cause = "quality factor and electronics change with temperature",
          .looks_like =
              "the error of a turn is proportional to its angle, by a share that drifts with the "
              "temperature",
          .manoeuvre = "turn cold and hot",
          .needs = kNeedsRate | kNeedsTemperature,
          .terms = {{"c", "1/degC"}},
          .typical_size = 3e-4,
          .size_source = "MPU-6050 data sheet 3.4, section 6.1: typically ±2 % from -40 to 85 degC",
          .c_expression = "{c0} * {w} * ({t} - {t0})",
          .basis = Make<ScaleTemperatureBasis>};
}

}  // namespace gyrobench::calibration
