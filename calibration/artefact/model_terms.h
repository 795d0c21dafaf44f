// The terms of a channel's model as functions of the state.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "base/measurement.h"
#include "calibration/effects/channel_model.h"
#include "calibration/state/sensor_state.h"

namespace gyrobench::calibration {

class TermFunction {
 public:
  virtual ~TermFunction() = default;
  // In deg/s. NaN where the state does not say. To be asked in the order of time; at one time as
  // often as one likes.
  virtual double At(const SensorState& point) = 0;
  // Whether the value depends on the rate.
  virtual bool depends_on_rate() const = 0;
};

// A rate effect of channel `axis`. Without one, `why_not` says what is missing: a column, an effect
// of another version.
std::unique_ptr<TermFunction> MakeTermFunction(const ModelTerm& term, SensorAxis axis,
                                               const MeasurementInfo& info, std::string* why_not);

}  // namespace gyrobench::calibration
