// Vibration that the element rectifies. Its mean square is taken over the n samples of 0.1 s, about
// their mean and by n: right for a tone, as of a resonance. Of broadband vibration it is low by
// 1/n, and c high by as much.
#include "calibration/effects/basis.h"
#include "calibration/effects/catalogue/makers.h"

namespace gyrobench::calibration {
namespace {

class VibrationBasis final : public ChannelBasis {
 public:
  using ChannelBasis::ChannelBasis;
  void At(const SensorState& point, double* terms) override { terms[0] = point.vibration_g2; }
};

}  // namespace

Effect BiasVibration() {
  return {.id = "bias.vibration",
          .equation = "c rms^2(a)",
          .cause = "vibration rectified by the element",
          .looks_like = "the zero-rate offset shifts while the accelerometer shows vibration",
          .manoeuvre = "sweep the speed through the stand's resonance",
          .needs = kNeedsVibration,
          .terms = {{"c", "deg/s/g^2"}},
          .typical_size = 10.0,
          .size_source = "experience with parts of this class: up to 10",
          .basis = Make<VibrationBasis>};
}

}  // namespace gyrobench::calibration
