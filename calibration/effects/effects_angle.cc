// Effects that add to the angle: of the reference, of the bench, and lags.
//
// The angle is the integral of the gyro's output against the reference. A term about one axis of
// the table is an error of that axis's angle; the trace turns it into the channel's.
#include <algorithm>
#include <cmath>

#include "calibration/effects/basis.h"
#include "calibration/effects/effect_tables.h"
#include "calibration/signal/columns.h"

namespace gyrobench::calibration {
namespace {

// Angle by which the gyro turned on from the point's time to `tau_s` after it [deg]: the cubic
// through the four known times about it; beyond those that are known at constant rate.
double TurnedOn(const TrackPoint& point, std::size_t channel, double tau_s) {
  if (point.turned_near_deg == nullptr) return kMissing;
  constexpr int kReach = static_cast<int>(kNear_s.size()) / 2;  // steps either way
  const Near& near = *point.turned_near_deg;
  auto at = [&](int step) {
    if (step == 0) return 0.0;
    return near[static_cast<std::size_t>(step < 0 ? step + kReach : step + kReach - 1)][channel];
  };
  const double u = tau_s / kNearStep_s;
  if (std::fabs(u) > kReach) {
    const int edge = u > 0 ? kReach : -kReach, inner = u > 0 ? kReach - 1 : 1 - kReach;
    return at(edge) + (u - edge) * (at(edge) - at(inner)) * (edge > 0 ? 1.0 : -1.0);
  }
  const int first = std::clamp(static_cast<int>(std::floor(u)) - 1, -kReach, kReach - 3);
  const double x = u - first;  // 0..3
  return -(x - 1) * (x - 2) * (x - 3) / 6.0 * at(first) +
         x * (x - 2) * (x - 3) / 2.0 * at(first + 1) - x * (x - 1) * (x - 3) / 2.0 * at(first + 2) +
         x * (x - 1) * (x - 2) / 6.0 * at(first + 3);
}

// The gyro's angle is late by tau: z(t) = Phi(t - tau), so that the reference has turned on by what
// the gyro will see within tau. Linear in tau only as long as the rate is constant.
class LatencyBasis final : public ChannelBasis {
 public:
  using ChannelBasis::ChannelBasis;
  void At(const TrackPoint& point, double* terms) override {
    constexpr double kShort_s = 1e-5;
    const double tau_s = context().nonlinear[0];
    const double by_s = std::fabs(tau_s) > kShort_s ? tau_s : kShort_s;
    terms[0] = -TurnedOn(point, context().channel, by_s) / by_s;
  }
};

// Behind a lag 1/(1 + s tau) the gyro shows w' with w = w' + tau dw'/dt: its angle stays behind by
// tau w', at the rate that it shows.
class LagBasis final : public ChannelBasis {
 public:
  using ChannelBasis::ChannelBasis;
  void At(const TrackPoint& point, double* terms) override {
    constexpr double kStep_s = 0.5 * kNearStep_s;
    terms[0] = -(TurnedOn(point, context().channel, kStep_s) -
                 TurnedOn(point, context().channel, -kStep_s)) /
               (2.0 * kStep_s);
  }
};

// -eps t w: the two clocks part, by a delay that grows with time.
class ClockDriftBasis final : public ChannelBasis {
 public:
  using ChannelBasis::ChannelBasis;
  void At(const TrackPoint& point, double* terms) override {
    constexpr double kShort_s = 1e-7;
    const double per_ppm_s = 1e-6 * point.t_s;
    const double tau_s = context().nonlinear[0] * per_ppm_s;
    const double by_s = std::fabs(tau_s) > kShort_s ? tau_s : kShort_s;
    terms[0] = -TurnedOn(point, context().channel, by_s) / by_s * per_ppm_s;
  }
};

// a sin(k phi) + b cos(k phi), k periods per turn of the table
class PeriodicBasis : public ChannelBasis {
 public:
  using ChannelBasis::ChannelBasis;

 protected:
  void Periodic(const TrackPoint& point, double periods, double* terms) const {
    const double x = periods * kRadPerDeg * point.reading_step_deg[context().table_axis];
    const double mean = MeanOfWave(point.readings, x);
    terms[0] = mean * std::sin(periods * table_rad(point));
    terms[1] = mean * std::cos(periods * table_rad(point));
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

// (b/2) sgn(last w), and on the way from one side to the other as far as the play has been crossed.
// Play between table and reference (b > 0, the gyro leads) is crossed while the reference stands,
// play before the table (b < 0) while the gyro does: whichever moves says how far.
class BacklashBasis final : public ChannelBasis {
 public:
  using ChannelBasis::ChannelBasis;
  void At(const TrackPoint& point, double* terms) override {
    const std::size_t axis = context().table_axis;
    const double b_deg = context().nonlinear[0];
    const bool by_reference =
        b_deg < -kClearPlay_deg || !std::isfinite(point.table_by_gyro_deg[axis]);
    const double angle_deg = by_reference ? point.table_deg[axis] : point.table_by_gyro_deg[axis];
    const double play_deg = std::max(std::fabs(b_deg), kLeastPlay_deg);
    if (point.restart) {
      ++power_ons_;
      follower_deg_ = kMissing;
    }
    if (std::isfinite(angle_deg)) {
      if (!std::isfinite(follower_deg_)) {
        follower_deg_ = angle_deg - StartSide() * play_deg;
      } else if (point.begins) {
        // Between measurements the reference alone says what the table turned by.
        const double moved_deg = point.table_deg[axis] - last_deg_;
        const bool moved = std::fabs(moved_deg) > kLeastMove_deg;
        const double lead_deg = side_ * play_deg + (moved ? moved_deg : 0.0);
        follower_deg_ = angle_deg - std::clamp(lead_deg, -0.5 * play_deg, 0.5 * play_deg);
      }
      side_ = MeanSide(point, angle_deg, play_deg);
    }
    last_deg_ = point.table_deg[axis];
    terms[0] = side_;
  }

 private:
  // The noise of the reference's readings must not pass for reversals: it is in the output as well,
  // and would be found there. A clear play stands out of it.
  static constexpr double kLeastPlay_deg = 0.005, kClearPlay_deg = 0.015;
  // Less is the noise of two readings.
  static constexpr double kLeastMove_deg = 0.05;

  double StartSide() const {
    const std::vector<double>& sides = context().start_sides;
    const std::size_t power_on = std::max<std::size_t>(power_ons_, 1) - 1;
    return power_on < sides.size() ? sides[power_on] : 0.0;
  }

  // On the way through the point; the mean over what it stands for.
  double MeanSide(const TrackPoint& point, double angle_deg, double play_deg) {
    const std::size_t axis = context().table_axis;
    const bool several = point.span_s() > 0.0;
    double sum = 0.0, count = 0.0;
    auto pass = [&](const Vector3& way, bool counts) {
      if (!std::isfinite(way[axis])) return;
      Follow(angle_deg + way[axis], play_deg);
      if (!counts) return;
      sum += (angle_deg + way[axis] - follower_deg_) / play_deg;
      count += 1.0;
    };
    // A mean is ahead of the instant while the table speeds up: the two do not mix.
    if (!several) pass(point.table_way_deg[0], false);
    pass(point.table_way_deg[1], several);
    pass(point.table_way_deg[2], several);
    pass({}, true);
    if (several) {
      for (const Vector3& way : point.table_way_on_deg) pass(way, true);
    }
    return sum / count;
  }
  void Follow(double angle_deg, double play_deg) {
    follower_deg_ =
        std::clamp(follower_deg_, angle_deg - 0.5 * play_deg, angle_deg + 0.5 * play_deg);
  }
  std::size_t power_ons_ = 0;  // begun
  double side_ = 0.0;
  double follower_deg_ = kMissing;
  double last_deg_ = kMissing;  // of the reference
};

// 1(t >= t0), the mean over what a point stands for
class AngleStepBasis final : public ChannelBasis {
 public:
  using ChannelBasis::ChannelBasis;
  void At(const TrackPoint& point, double* terms) override {
    const double since_s = point.t_s - context().nonlinear[0], span_s = point.span_s();
    terms[0] = span_s > 0.0 ? std::clamp(0.5 + since_s / span_s, 0.0, 1.0)
                            : static_cast<double>(since_s >= 0.0);
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
  effect.tied = effect.id == "angle.latency" || effect.id == "angle.backlash" ||
                effect.id == "angle.clock_drift";
  // A pure delay is the simpler cause of the same.
  if (effect.id == "bandwidth.first_order") {
    effect.handicap = 10.0;
    effect.positive = true;
  }
  return effect;
}

}  // namespace

std::vector<Effect> AngleEffects() {
  using enum EffectOwner;
  const std::vector<EffectTerm> sine = {{"a", "deg"}, {"b", "deg"}};
  return {
      Angle("angle.latency", kBench, "-tau w",
            "delay of the bus or the filter; negative: of the encoder",
            "accelerate, reverse, or swing in a sine", kNeedsRate, {{"tau", "s"}}, 0.02,
            Make<LatencyBasis>, {{"tau", "s", -0.2, 0.2, {0.0}}}),
      Angle("bandwidth.first_order", kGyro, "1 / (1 + s tau)", "the gyro's filter or its mechanics",
            "swing in a sine up to 0.3 of the bandwidth", kNeedsRate, {{"tau", "s"}}, 0.02,
            Make<LagBasis>),
      Angle("angle.clock_drift", kBench, "-eps t w", "two clocks that part",
            "repeat a motion after 30 min", kNeedsRate, {{"eps", "ppm"}}, 100.0,
            Make<ClockDriftBasis>, {{"eps", "ppm", -1000.0, 1000.0, {0.0}}}),
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
            Make<BacklashBasis>, {{"b", "deg", -1.0, 1.0, {0.0}}}),
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
