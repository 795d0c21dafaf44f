// A rate that is not there oscillates.
#include <cmath>

#include "calibration/effects/basis.h"
#include "calibration/effects/catalogue/makers.h"

namespace gyrobench::calibration {
namespace {

// The integral of a sin(2 pi f t + p) as its two parts, the mean over the readings of a point.
class ToneBasis final : public ChannelBasis {
 public:
  using ChannelBasis::ChannelBasis;
  void At(const SensorState& point, double* terms) override {
    const double omega = kTwoPi * context().nonlinear[0];
    const double mean = MeanOfWave(point.readings, omega * point.reading_step_s) / omega;
    terms[0] = -mean * std::cos(omega * point.t_s);
    terms[1] = mean * std::sin(omega * point.t_s);
  }
};

}  // namespace

Effect BiasTone() {
  return {.id = "bias.tone",
          .domain = EffectDomain::kRateIntegral,
          .equation = "a sin(2 pi f t) + b cos(2 pi f t)",
          .cause = "interference, or vibration seen through aliasing",
          .looks_like = "the output oscillates at rest, at one frequency that lasts",
          .manoeuvre = "rest",
          .terms = {{"a", "deg/s"}, {"b", "deg/s"}},
          .nonlinear = {{"f", "Hz"}},
          .search = Search::kFrequency,
          .typical_size = 1.0,
          .size_source = "experience with parts of this class: 0.01 to 1",
          .of_each_reading = true,
          .basis = Make<ToneBasis>};
}

}  // namespace gyrobench::calibration
