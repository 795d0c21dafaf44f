// Vibration that the element rectifies, where no accelerometer shows it: the resonance of the
// stand.
#include <cmath>

#include "calibration/effects/basis.h"
#include "calibration/effects/catalogue/makers.h"

namespace gyrobench::calibration {
namespace {

// A ramp crosses the resonance within one interval: the mean over the rates it goes through,
//   width / (w1 - w0) (atan((w1 - f0) / width) - atan((w0 - f0) / width)).
class ResonanceBasis final : public ChannelBasis {
 public:
  using ChannelBasis::ChannelBasis;
  void At(const SensorState& point, double* terms) override {
    terms[0] = 0.0;
    if (point.still) return;
    if (!context().of_stand) {
      terms[0] = MeanOver(rate(point), point.rate_span_deg_s[context().channel]);
      return;
    }
    const Vector3& span = point.rate_span_deg_s;
    // About which of the axes is not known where several turn.
    const double span_deg_s = std::hypot(span[0], span[1], span[2]);
    for (const double rate_deg_s : point.table_rate_deg_s) {
      if (std::fabs(rate_deg_s) > kTurns_deg_s) terms[0] += MeanOver(rate_deg_s, span_deg_s);
    }
  }

 private:
  // An axis that hardly turns rests: its reading has noise.
  static constexpr double kTurns_deg_s = 0.3;

  double MeanOver(double rate_deg_s, double span_deg_s) const {
    const double width = context().nonlinear[1];
    const double middle = std::fabs(rate_deg_s) - context().nonlinear[0];
    const double half_span = 0.5 * std::fabs(span_deg_s);
    if (half_span < 0.1 * width) return 1.0 / (1.0 + middle * middle / (width * width));
    return 0.5 * width / half_span *
           (std::atan((middle + half_span) / width) - std::atan((middle - half_span) / width));
  }
};

// A resonance beyond all speeds is never met.
bool IsReached(const DataRange& data, const std::vector<double>& nonlinear) {
  constexpr double kJustBeyond = 1.2;
  return !(nonlinear[0] > kJustBeyond * data.max_rate_deg_s);
}

}  // namespace

Effect BiasVibrationAtResonance() {
  return {.id = "bias.vibration",
          .equation = "A / (1 + ((|w| - f0) / width)^2) while the table turns",
          .cause = "vibration of the steps rectified by the element, at the stand's resonance",
          .looks_like =
              "the zero-rate offset shifts at some speeds of the table, the same way in both "
              "directions",
          .manoeuvre = "sweep the speed through the stand's resonance",
          .needs = kNeedsRate,
          .terms = {{"A", "deg/s"}},
          .nonlinear = {{"f0", "deg/s", 1.0, 500.0, {3,  5,  7,  9,  11, 14,  18,  22,  27,  33,
                                                     40, 48, 58, 70, 84, 100, 120, 150, 180, 220}},
                        {"width", "deg/s", 0.3, 30.0, {1.0, 3.0}}},
          .search = Search::kGrid,
          .typical_size = 0.5,
          .size_source = "experience with stands of this class: 0.01 to 0.5",
          .shakes_stand = true,
          .makes_sense = IsReached,
          .basis = Make<ResonanceBasis>};
}

}  // namespace gyrobench::calibration
