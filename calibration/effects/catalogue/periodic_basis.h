// Errors of an angle that repeat with the turn of a table: a sin(k phi) + b cos(k phi), k periods
// per turn. The angle is the integral of the gyro's output against the reference; a term about one
// axis of the table is an error of that axis's angle, which the trace turns into the channel's.
#pragma once

#include <cmath>

#include "calibration/effects/basis.h"

namespace gyrobench::calibration {

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

}  // namespace gyrobench::calibration
