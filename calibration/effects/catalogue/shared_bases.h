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

class PeriodicBasis : public ChannelBasis {
 public:
  using ChannelBasis::ChannelBasis;
  void At(const SensorState& point, double* terms) final {
    const double k = periods();
    const double x = k * kRadPerDeg * point.reading_step_deg[context().table_axis];
    const double mean = MeanOfWave(point.readings, x);
    terms[0] = mean * std::sin(k * table_rad(point));
    terms[1] = mean * std::cos(k * table_rad(point));
  }

 private:
  virtual double periods() const = 0;
};

// Angle by which the gyro turned on from the point's time to `tau_s` after it [deg], by a cubic
// through the four known times about that; before the first node and after the last at constant
// rate. NaN where the point is no node.
double TurnedOn(const SensorState& point, std::size_t channel, double tau_s);

}  // namespace gyrobench::calibration
