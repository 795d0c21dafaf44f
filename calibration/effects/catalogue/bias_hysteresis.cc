// The zero-rate offset depends on the way by which a temperature was reached.
#include <algorithm>
#include <cmath>

#include "calibration/effects/basis.h"
#include "calibration/effects/catalogue/makers.h"

namespace gyrobench::calibration {
namespace {

// The play operator follows T at a distance of r at most.
class HysteresisBasis final : public ChannelBasis {
 public:
  using ChannelBasis::ChannelBasis;
  void At(const SensorState& point, double* terms) override {
    const double temperature = point.temperature_degC;
    const double play = context().nonlinear[0];
    if (point.restart) ++power_ons_;
    // A package keeps the stress of what it went through before.
    if (point.restart || !started_)
      follower_ = temperature - 2.0 * play * start_side(std::max<std::size_t>(power_ons_, 1) - 1);
    // Where the temperature is not known, the follower waits.
    started_ = std::isfinite(follower_);
    follower_ = std::fmin(std::fmax(follower_, temperature - play), temperature + play);
    terms[0] = follower_ - temperature;
  }

 private:
  std::size_t power_ons_ = 0;  // begun
  bool started_ = false;
  double follower_ = 0.0;
};

// Play that is wider than the temperatures is never taken up.
bool IsCrossed(const DataRange& data, const std::vector<double>& nonlinear) {
  return !(2.0 * nonlinear[0] > data.temperature_degC);
}

}  // namespace

Effect BiasHysteresis() {
  return {.id = "bias.hysteresis",
          .equation = "c (P_r[T] - T)",
          .cause = "stress of the package",
          .looks_like =
              "the zero-rate offset against temperature has two branches, one heating and one "
              "cooling, that part after each reversal",
          .manoeuvre = "heat, cool and heat again",
          .needs = kNeedsTemperature,
          .terms = {{"c", "deg/s/degC"}},
          .nonlinear = {{"r", "degC", 0.1, 20.0, {0.5, 1.0, 2.0, 3.5, 6.0}}},
          .search = Search::kGrid,
          .typical_size = 0.1,
          .size_source = "experience with parts of this class: 0.01 to 0.1",
          .slow = true,
          .unknown_start = true,
          .makes_sense = IsCrossed,
          .basis = Make<HysteresisBasis>};
}

}  // namespace gyrobench::calibration
