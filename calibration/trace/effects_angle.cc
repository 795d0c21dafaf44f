// Effects that add to the angle: of the reference, of the bench, and lags.
//
// The angle is the integral of the gyro's output against the reference. A term about one axis of
// the table is an error of that axis's angle; the trace turns it into the channel's.
#include <cmath>

#include "calibration/trace/basis.h"
#include "calibration/trace/effect_tables.h"

namespace gyrobench::calibration {
namespace {

// -tau w
class LatencyBasis final : public ChannelBasis {
 public:
  using ChannelBasis::ChannelBasis;
  void At(const TrackPoint& point, double* terms) override { terms[0] = -rate(point); }
};

// The angle behind a lag 1/(1 + s tau) stays behind by tau times the lagged rate:
//   w_lag(t) = int_0^inf w(t - s) exp(-s / tau) ds / tau,
// of a rate that is constant over the last 20 ms, over the 20 ms before and ever before.
class LagBasis final : public ChannelBasis {
 public:
  using ChannelBasis::ChannelBasis;
  void At(const TrackPoint& point, double* terms) override {
    const std::size_t c = context().channel;
    const double decay = std::exp(-0.02 / context().nonlinear[0]);
    terms[0] = -((1.0 - decay) * point.rate_last_deg_s[c] +
                 decay * (1.0 - decay) * point.rate_before_deg_s[c] +
                 decay * decay * point.rate_earlier_deg_s[c]);
  }
};

// -eps t w: the two clocks part
class ClockDriftBasis final : public ChannelBasis {
 public:
  using ChannelBasis::ChannelBasis;
  void At(const TrackPoint& point, double* terms) override {
    terms[0] = -1e-6 * point.t_s * rate(point);
  }
};

// a sin(k phi) + b cos(k phi), k periods per turn of the table
class PeriodicBasis : public ChannelBasis {
 public:
  using ChannelBasis::ChannelBasis;

 protected:
  void Periodic(const TrackPoint& point, double periods, double* terms) const {
    terms[0] = std::sin(periods * table_rad(point));
    terms[1] = std::cos(periods * table_rad(point));
  }
};
template <int kPeriods>
class TablePeriodBasis final : public PeriodicBasis {
 public:
  using PeriodicBasis::PeriodicBasis;
  void At(const TrackPoint& point, double* terms) override { Periodic(point, kPeriods, terms); }
};
class ShaftPeriodBasis final : public PeriodicBasis {
 public:
  using PeriodicBasis::PeriodicBasis;
  void At(const TrackPoint& point, double* terms) override {
    Periodic(point, context().nonlinear[0] * context().gear_ratio, terms);
  }
};
class RippleBasis final : public PeriodicBasis {
 public:
  using PeriodicBasis::PeriodicBasis;
  void At(const TrackPoint& point, double* terms) override {
    Periodic(point, context().nonlinear[0], terms);
  }
};

// (b/2) sgn(last w)
class BacklashBasis final : public ChannelBasis {
 public:
  using ChannelBasis::ChannelBasis;
  void At(const TrackPoint& point, double* terms) override {
    const double w = point.table_rate_deg_s[context().table_axis];
    if (!point.still && std::fabs(w) > kLeastMotion_deg_s) side_ = w > 0 ? 0.5 : -0.5;
    terms[0] = side_;
  }

 private:
  static constexpr double kLeastMotion_deg_s = 0.3;
  double side_ = 0.0;
};

// 1(t >= t0)
class AngleStepBasis final : public ChannelBasis {
 public:
  using ChannelBasis::ChannelBasis;
  void At(const TrackPoint& point, double* terms) override {
    terms[0] = point.t_s >= context().nonlinear[0] ? 1.0 : 0.0;
  }
};

Effect Angle(std::string id, EffectOwner owner, std::string equation, std::string cause,
             std::string manoeuvre, unsigned needs, std::vector<EffectTerm> terms,
             double typical_size, BasisMaker basis,
             std::vector<NonlinearParameter> nonlinear = {}) {
  Effect effect;
  effect.id = std::move(id);
  effect.domain = EffectDomain::kAngle;
  effect.owner = owner;
  effect.equation = std::move(equation);
  effect.cause = std::move(cause);
  effect.manoeuvre = std::move(manoeuvre);
  effect.needs = needs;
  effect.terms = std::move(terms);
  effect.nonlinear = std::move(nonlinear);
  effect.typical_size = typical_size;
  effect.basis = basis;
  effect.tied = effect.id == "bandwidth.first_order";
  return effect;
}

}  // namespace

std::vector<Effect> AngleEffects() {
  using enum EffectOwner;
  const std::vector<EffectTerm> sine = {{"a", "deg"}, {"b", "deg"}};
  return {
      Angle("angle.latency", kBench, "-tau w", "delay of the bus, the filter or the encoder",
            "accelerate, reverse, or swing in a sine", kNeedsRate, {{"tau", "s"}}, 0.02,
            Make<LatencyBasis>),
      Angle("bandwidth.first_order", kGyro, "1 / (1 + s tau)", "the gyro's filter or its mechanics",
            "swing in a sine up to 0.3 of the bandwidth", kNeedsRate, {{"tau", "s"}}, 0.02,
            Make<LagBasis>, {{"tau", "s", 1e-3, 0.05, {0.005, 0.015}}}),
      Angle("angle.clock_drift", kBench, "-eps t w", "two clocks that part",
            "repeat a motion after 30 min", kNeedsRate, {{"eps", "ppm"}}, 100.0,
            Make<ClockDriftBasis>),
      Angle("angle.worm_period", kBench, "a sin(psi) + b cos(psi), psi the shaft's angle",
            "eccentric worm", "turn slowly by parts of a shaft turn, finely sampled",
            kNeedsRate | kNeedsTableAxis, sine, 0.025, Make<ShaftPeriodBasis>,
            {{"harmonic", "1/turn", 0.0, 0.0, {1.0, 2.0}}}),
      Angle("angle.eccentricity_1", kReference, "a sin(phi) + b cos(phi)",
            "the encoder's disc is off centre", "turn by 360 deg and more",
            kNeedsRate | kNeedsTableAxis, sine, 0.05, Make<TablePeriodBasis<1>>),
      Angle("angle.eccentricity_2", kReference, "a sin(2 phi) + b cos(2 phi)",
            "the encoder's disc is off centre or oval", "turn by 360 deg and more",
            kNeedsRate | kNeedsTableAxis, sine, 0.05, Make<TablePeriodBasis<2>>),
      Angle("angle.backlash", kBench, "(b/2) sgn(last w)", "play in the gear",
            "reverse the direction", kNeedsRate | kNeedsTableAxis, {{"b", "deg"}}, 0.1,
            Make<BacklashBasis>),
      Angle("angle.ripple", kBench, "a sin(k phi) + b cos(k phi)",
            "steps of the motor, teeth of a gear, or lines of the encoder",
            "turn at constant speed, slowly", kNeedsRate | kNeedsTableAxis, sine, 0.5,
            Make<RippleBasis>, {{"k", "1/turn", 0.0, 0.0, {}}}),
      Angle("angle.step", kReference, "b 1(t >= t0)",
            "a lost or doubled sample, lost steps, a slipped reference",
            "check the counters of samples and steps", kNeedsRate | kNeedsTableAxis, {{"b", "deg"}},
            0.5, Make<AngleStepBasis>, {{"t0", "s", 0.0, 0.0, {}}}),
  };
}

}  // namespace gyrobench::calibration
