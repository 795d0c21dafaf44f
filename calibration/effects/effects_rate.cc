// Effects that add to the rate: bias.*, scale.*, bandwidth.*.
#include <cmath>

#include "calibration/effects/basis.h"
#include "calibration/effects/effect_tables.h"

namespace gyrobench::calibration {
namespace {

// k . g
class GravityBasis final : public ChannelBasis {
 public:
  using ChannelBasis::ChannelBasis;
  void At(const TrackPoint& point, double* terms) override {
    for (std::size_t i = 0; i < 3; ++i) terms[i] = point.gravity_g[i];
  }
};

// k_x g_x^2 + k_y g_y^2: with g_x^2 + g_y^2 + g_z^2 = 1 the third is a constant.
class GravitySquaredBasis final : public ChannelBasis {
 public:
  using ChannelBasis::ChannelBasis;
  void At(const TrackPoint& point, double* terms) override {
    terms[0] = point.gravity_g[0] * point.gravity_g[0];
    terms[1] = point.gravity_g[1] * point.gravity_g[1];
  }
};

// c_i g_i w
class ScaleGravityBasis final : public ChannelBasis {
 public:
  using ChannelBasis::ChannelBasis;
  void At(const TrackPoint& point, double* terms) override {
    for (std::size_t i = 0; i < 3; ++i) terms[i] = point.gravity_g[i] * rate(point);
  }
};

// c w (T - T0)
class ScaleTemperatureBasis final : public ChannelBasis {
 public:
  using ChannelBasis::ChannelBasis;
  void At(const TrackPoint& point, double* terms) override {
    terms[0] = rate(point) * (point.temperature_degC - context().reference_degC);
  }
};

// A function of the channel's rate alone.
template <double (*kShape)(double rate_deg_s)>
class RateBasis final : public ChannelBasis {
 public:
  using ChannelBasis::ChannelBasis;
  void At(const TrackPoint& point, double* terms) override { terms[0] = kShape(rate(point)); }
};
double OddSquare(double w) { return w * std::fabs(w); }
double Cube(double w) { return w * w * w; }
double Square(double w) { return w * w; }
double Size(double w) { return std::fabs(w); }

// c dT/dt
class TemperatureRateBasis final : public ChannelBasis {
 public:
  using ChannelBasis::ChannelBasis;
  void At(const TrackPoint& point, double* terms) override {
    terms[0] = point.temperature_rate_degC_s;
  }
};

// c (P_r[T] - T): the play operator follows T at a distance of r at most.
class HysteresisBasis final : public ChannelBasis {
 public:
  using ChannelBasis::ChannelBasis;
  void At(const TrackPoint& point, double* terms) override {
    const double temperature = point.temperature_degC;
    if (point.restart || !started_) follower_ = temperature;
    // Where it is not known, the follower waits.
    started_ = std::isfinite(follower_);
    const double play = context().nonlinear[0];
    follower_ = std::fmin(std::fmax(follower_, temperature - play), temperature + play);
    terms[0] = follower_ - temperature;
  }

 private:
  bool started_ = false;
  double follower_ = 0.0;
};

// A exp(-t / tau), t since power-on
class WarmUpBasis final : public ChannelBasis {
 public:
  using ChannelBasis::ChannelBasis;
  void At(const TrackPoint& point, double* terms) override {
    terms[0] = std::exp(-point.since_power_on_s / context().nonlinear[0]);
  }
};

// c rms^2(a) as the accelerometer feels it
class VibrationBasis final : public ChannelBasis {
 public:
  using ChannelBasis::ChannelBasis;
  void At(const TrackPoint& point, double* terms) override { terms[0] = point.vibration_g2; }
};

// A / (1 + ((|w| - f0) / width)^2) while the table turns. A ramp crosses the resonance within one
// interval: the mean over the rates it goes through,
//   width / (w1 - w0) (atan((w1 - f0) / width) - atan((w0 - f0) / width)).
class ResonanceBasis final : public ChannelBasis {
 public:
  using ChannelBasis::ChannelBasis;
  void At(const TrackPoint& point, double* terms) override {
    const double width = context().nonlinear[1];
    const double middle = std::fabs(rate(point)) - context().nonlinear[0];
    const double half_span = 0.5 * std::fabs(point.rate_span_deg_s[context().channel]);
    if (point.still) {
      terms[0] = 0.0;
    } else if (half_span < 0.1 * width) {
      terms[0] = 1.0 / (1.0 + middle * middle / (width * width));
    } else {
      terms[0] =
          0.5 * width / half_span *
          (std::atan((middle + half_span) / width) - std::atan((middle - half_span) / width));
    }
  }
};

// c (x - mean)
class CovariateBasis final : public ChannelBasis {
 public:
  using ChannelBasis::ChannelBasis;
  void At(const TrackPoint& point, double* terms) override {
    terms[0] = point.covariates[context().covariate] - context().covariate_mean;
  }
};

// c w (x - mean)
class ScaleCovariateBasis final : public ChannelBasis {
 public:
  using ChannelBasis::ChannelBasis;
  void At(const TrackPoint& point, double* terms) override {
    terms[0] = rate(point) * (point.covariates[context().covariate] - context().covariate_mean);
  }
};

// Earth's rotation, w_north on world x and y (headings are not known here), w_up on z; nothing
// where it is in the rates.
class EarthBasis final : public ChannelBasis {
 public:
  using ChannelBasis::ChannelBasis;
  void At(const TrackPoint& point, double* terms) override {
    const std::size_t c = context().channel;
    const Vector3& x = point.world_x;
    const Vector3& z = point.gravity_g;
    const Vector3 y = {z[1] * x[2] - z[2] * x[1], z[2] * x[0] - z[0] * x[2],
                       z[0] * x[1] - z[1] * x[0]};
    terms[0] = point.earth_rate_known ? 0.0 : z[c];
    terms[1] = point.earth_rate_known ? 0.0 : x[c];
    terms[2] = point.earth_rate_known ? 0.0 : y[c];
  }
};

// b 1(t >= t0)
class BiasStepBasis final : public ChannelBasis {
 public:
  using ChannelBasis::ChannelBasis;
  void At(const TrackPoint& point, double* terms) override {
    terms[0] = point.t_s >= context().nonlinear[0] ? 1.0 : 0.0;
  }
};

// The integral of a sin(2 pi f t + p) as its two parts, the mean over the readings of a point.
class ToneBasis final : public ChannelBasis {
 public:
  using ChannelBasis::ChannelBasis;
  void At(const TrackPoint& point, double* terms) override {
    const double omega = kTwoPi * context().nonlinear[0];
    const double mean = MeanOfWave(point.readings, omega * point.reading_step_s) / omega;
    terms[0] = -mean * std::cos(omega * point.t_s);
    terms[1] = mean * std::sin(omega * point.t_s);
  }
};

Effect Rate(std::string id, std::string equation, std::string cause, std::string manoeuvre,
            unsigned needs, std::vector<EffectTerm> terms, double typical_size, BasisMaker basis) {
  Effect effect;
  effect.id = std::move(id);
  effect.equation = std::move(equation);
  effect.cause = std::move(cause);
  effect.manoeuvre = std::move(manoeuvre);
  effect.needs = needs;
  effect.terms = std::move(terms);
  effect.typical_size = typical_size;
  effect.basis = basis;
  return effect;
}

Effect Integral(Effect effect) {
  effect.domain = EffectDomain::kRateIntegral;
  return effect;
}

Effect Limited(Effect effect) {
  effect.limited = true;
  return effect;
}

Effect With(Effect effect, std::vector<NonlinearParameter> nonlinear) {
  effect.nonlinear = std::move(nonlinear);
  return effect;
}

}  // namespace

std::vector<Effect> RateEffects() {
  return {
      Rate("bias.g_linear", "k . g", "mass unbalance of the element, shift of its quadrature error",
           "hold six poses, or turn about a horizontal axis", kNeedsGravity,
           {{"k_x", "deg/s/g"}, {"k_y", "deg/s/g"}, {"k_z", "deg/s/g"}}, 0.1, Make<GravityBasis>),
      Rate("bias.g_squared", "k_x g_x^2 + k_y g_y^2", "electrodes bend under the specific force",
           "hold poses with each axis up and down", kNeedsGravity,
           {{"k_x", "deg/s/g^2"}, {"k_y", "deg/s/g^2"}}, 0.02, Make<GravitySquaredBasis>),
      Rate("scale.g", "(c_x g_x + c_y g_y + c_z g_z) w",
           "the electrodes' gap, and with it the gain, changes with the specific force",
           "turn at the same speeds with the axis up, down and horizontal",
           kNeedsGravity | kNeedsRate, {{"c_x", "1/g"}, {"c_y", "1/g"}, {"c_z", "1/g"}}, 1e-3,
           Make<ScaleGravityBasis>),
      Rate("scale.temperature", "c w (T - T0)",
           "quality factor and electronics change with temperature", "turn cold and hot",
           kNeedsRate | kNeedsTemperature, {{"c", "1/degC"}}, 3e-4, Make<ScaleTemperatureBasis>),
      Rate("scale.quadratic_odd", "c w |w|", "nonlinearity of electrodes or converter",
           "turn at six speeds and more, up to half the range", kNeedsRate, {{"c", "1/(deg/s)"}},
           5e-5, Make<RateBasis<OddSquare>>),
      Rate("scale.cubic", "c w^3", "nonlinearity of electrodes or converter",
           "turn at six speeds and more, up to half the range", kNeedsRate, {{"c", "1/(deg/s)^2"}},
           1e-6, Make<RateBasis<Cube>>),
      Rate("scale.quadratic_even", "c w^2", "nonlinearity of electrodes or converter",
           "turn at several speeds both ways", kNeedsRate, {{"c", "1/(deg/s)"}}, 2.5e-5,
           Make<RateBasis<Square>>),
      Rate("scale.asymmetry", "c |w|", "another gain for each sign of the rate",
           "turn at the same speeds both ways", kNeedsRate, {{"c", "1"}}, 1e-3,
           Make<RateBasis<Size>>),
      Rate("bias.temperature_rate", "c dT/dt",
           "gradient across the die, or a thermometer that lags behind it",
           "two thermal histories: warm up, then cool by a fan", kNeedsTemperature,
           {{"c", "deg/s/(degC/s)"}}, 1.0, Make<TemperatureRateBasis>),
      With(Rate("bias.hysteresis", "c (P_r[T] - T)", "stress of the package",
                "heat, cool and heat again", kNeedsTemperature, {{"c", "deg/s/degC"}}, 0.1,
                Make<HysteresisBasis>),
           {{"r", "degC", 0.1, 20.0, {0.5, 1.0, 2.0, 3.5, 6.0}}}),
      With(Rate("bias.warm_up", "A exp(-t/tau), t since power-on", "self-heating after power-on",
                "start twice, from different temperatures", kNeedsNothing, {{"A", "deg/s"}}, 0.3,
                Make<WarmUpBasis>),
           {{"tau", "s", 5.0, 600.0, {15, 30, 60, 100, 170, 300, 550}}}),
      Rate("bias.vibration", "c rms^2(a)", "vibration rectified by the element",
           "sweep the speed through the stand's resonance", kNeedsVibration, {{"c", "deg/s/g^2"}},
           10.0, Make<VibrationBasis>),
      With(Rate("bias.vibration", "A / (1 + ((|w| - f0) / width)^2) while the table turns",
                "vibration of the steps rectified by the element, at the stand's resonance",
                "sweep the speed through the stand's resonance", kNeedsRate, {{"A", "deg/s"}}, 0.5,
                Make<ResonanceBasis>),
           {{"f0", "deg/s", 1.0, 500.0, {3,  5,  7,  9,  11, 14,  18,  22,  27,  33,
                                         40, 48, 58, 70, 84, 100, 120, 150, 180, 220}},
            {"width", "deg/s", 0.3, 30.0, {1.0, 3.0}}}),
      Rate("bias.of", "c (x - mean)", "whatever moves with the column", "vary the column",
           kNeedsCovariate, {{"c", "deg/s per unit"}}, 0.0, Make<CovariateBasis>),
      Rate("scale.of", "c w (x - mean)", "whatever moves with the column",
           "vary the column while turning", kNeedsCovariate | kNeedsRate, {{"c", "1 per unit"}},
           0.0, Make<ScaleCovariateBasis>),
      Limited(Rate("bias.earth_rate", "w_E in the sensor's frame",
                   "Earth's rotation, where the site's latitude is not configured",
                   "configure the site's latitude and heading", kNeedsGravity,
                   {{"up", "deg/s"}, {"world_x", "deg/s"}, {"world_y", "deg/s"}}, 0.0042,
                   Make<EarthBasis>)),
      With(Rate("bias.step", "b 1(t >= t0)", "stress, supply or a restart",
                "none: it is found where it happens", kNeedsNothing, {{"b", "deg/s"}}, 0.5,
                Make<BiasStepBasis>),
           {{"t0", "s", 0.0, 0.0, {}}}),
      With(Integral(Rate("bias.tone", "a sin(2 pi f t) + b cos(2 pi f t)",
                         "interference, or vibration seen through aliasing", "rest", kNeedsNothing,
                         {{"a", "deg/s"}, {"b", "deg/s"}}, 1.0, Make<ToneBasis>)),
           {{"f", "Hz", 0.0, 0.0, {}}}),
  };
}

}  // namespace gyrobench::calibration
