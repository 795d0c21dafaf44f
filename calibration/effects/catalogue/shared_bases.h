// What the bases of several effects share.
#pragma once

#include <cmath>

#include "calibration/effects/basis.h"
#include "calibration/effects/effect.h"

namespace gyrobench::calibration {

template <double (*kShape)(double rate_deg_s)>
class RateBasis final : public ChannelBasis {
 public:
  using ChannelBasis::ChannelBasis;
  void At(const SensorState& point, double* terms) override { terms[0] = kShape(rate(point)); }
};

// Mean of sin and cos of a wave of the table's angle over the readings of a node. `angle_deg`: the
// mean of their angles; how each lies about it the gyro says. False where it does not.
bool WaveOverReadings(const SensorState& point, std::size_t table_axis, double angle_deg,
                      double periods, double* sin_and_cos);

class PeriodicBasis : public ChannelBasis {
 public:
  using ChannelBasis::ChannelBasis;
  void At(const SensorState& point, double* terms) final {
    // Where all readings span less of the wave, it is no matter whether all turn by as much.
    constexpr double kMuch_rad = 1.0;
    const std::size_t axis = context().table_axis;
    const double k = periods();
    const double own_deg = point.own_part_deg[axis];
    const double angle_deg =
        point.table_deg[axis] + (own_deg != 0.0 && IsLong(point, k) ? own_deg : 0.0);
    const double x = k * kRadPerDeg * point.reading_step_deg[axis];
    const bool much = std::fabs(x) * static_cast<double>(point.readings) > kMuch_rad;
    if (much && WaveOverReadings(point, axis, angle_deg, k, terms)) return;
    const double mean = MeanOfWave(point.readings, x);
    const double phase = k * angle_deg * kRadPerDeg;
    terms[0] = mean * std::sin(phase);
    terms[1] = mean * std::cos(phase);
  }

 private:
  // A turn: the data know more of them than of the errors of the angle.
  static constexpr double kFewPeriods = 4.0;

  // Of few periods, or of so many that it is nearly the same from node to node: to the nodes that is
  // one of few as well.
  bool IsLong(const SensorState& point, double k) const {
    const double step_turns = point.steady_step_deg[context().table_axis] / kFullTurn_deg;
    return k < kFewPeriods ||
           std::fabs(std::remainder(k * step_turns, 1.0)) < kFewPeriods * std::fabs(step_turns);
  }

  virtual double periods() const = 0;
};

// z(t) = Phi(t - tau), so that the reference has turned on by what the gyro will see within tau
// from the stamp of its reading on: this over tau. Linear in tau only as long as the rate is
// constant.
inline double TurnedOnWithin(const SensorState& point, std::size_t channel, double tau_s) {
  constexpr double kShort_s = 1e-7;
  const double by_s = std::fabs(tau_s) > kShort_s ? tau_s : kShort_s;
  const double to_stamp_s = -point.drift_correction_s;
  const double from_stamp_deg = TurnedOn(point, channel, to_stamp_s + by_s);
  // Nothing was corrected in most measurements: the node is at the stamp.
  if (to_stamp_s == 0.0) return from_stamp_deg / by_s;
  return (from_stamp_deg - TurnedOn(point, channel, to_stamp_s)) / by_s;
}

template <DelayFunction kDelay_s>
class DelayBasis final : public ChannelBasis {
 public:
  using ChannelBasis::ChannelBasis;
  void At(const SensorState& point, double* terms) override {
    const double stamp_s = point.stamp_s();
    const double all_s = kDelay_s(context().nonlinear[0], stamp_s) + other_delays_s(stamp_s);
    terms[0] = -TurnedOnWithin(point, context().channel, all_s) * kDelay_s(1.0, stamp_s);
  }
};

}  // namespace gyrobench::calibration
