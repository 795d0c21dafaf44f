// Effects that are a function of the channel's own rate.
#pragma once

#include "calibration/effects/basis.h"

namespace gyrobench::calibration {

template <double (*kShape)(double rate_deg_s)>
class RateBasis final : public ChannelBasis {
 public:
  using ChannelBasis::ChannelBasis;
  void At(const SensorState& point, double* terms) override { terms[0] = kShape(rate(point)); }
};

}  // namespace gyrobench::calibration
