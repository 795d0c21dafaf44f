// What a channel shows of the reference's error about the channel's axis. All channels have a use
// for it: each feels that axis by its cross-axis part, and they share the clock and the filter.
#pragma once

#include <array>
#include <memory>
#include <span>
#include <vector>

#include "calibration/effects/effect.h"

namespace gyrobench::calibration {

struct StateHistory;

struct ReferenceAngleError {
  // By history and interval: by how much more the sensor turned about the axis than the reference
  // says, as the gyro's filter passes it [deg]; 0 where the channel was not used.
  std::vector<std::vector<double>> turn_beyond_deg;
  std::vector<Delay> delays;  // that are named
};
// By sensor axis; nullptr: the axis does not turn, or nothing is named that acts on its angle.
using ReferenceAngleErrors = std::array<std::shared_ptr<const ReferenceAngleError>, 3>;

// The longest that the delays add up to in the measurements, either way [s].
double LongestDelay_s(std::span<const StateHistory> histories, const std::vector<Delay>& delays);

}  // namespace gyrobench::calibration
