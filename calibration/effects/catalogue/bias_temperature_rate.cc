// The zero-rate offset depends on how fast the temperature changes.
#include "calibration/effects/basis.h"
#include "calibration/effects/catalogue/makers.h"

namespace gyrobench::calibration {
namespace {

class TemperatureRateBasis final : public ChannelBasis {
 public:
  using ChannelBasis::ChannelBasis;
  void At(const SensorState& point, double* terms) override {
    terms[0] = point.temperature_rate_degC_s;
  }
};

}  // namespace

Effect BiasTemperatureRate() {
  return {.id = "bias.temperature_rate",
          .equation = "c dT/dt",
          .cause = "gradient across the die, or a thermometer that lags behind it",
          .looks_like =
              "at the same temperature the zero-rate offset is different while the sensor heats up "
              "than while it cools",
          .manoeuvre = "two thermal histories: warm up, then cool by a fan",
          .needs = kNeedsTemperature,
          .terms = {{"c", "deg/s/(degC/s)"}},
          .typical_size = 1.0,
          .size_source = "experience with parts of this class: 0.1 to 1",
          // The rate of a thermometer that is noisy and has steps: in two sets of 100 standard
          // deviations its product with gravity explained 0.2 and 0.3 % of what it explains itself.
          .shape_error = 0.055,
          .slow = true,
          .c_expression = "{c0} * in->temperature_rate_degC_s",
          .basis = Make<TemperatureRateBasis>};
}

}  // namespace gyrobench::calibration
