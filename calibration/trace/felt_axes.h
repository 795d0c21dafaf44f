// How a channel feels the axes of the stand.
#pragma once

#include <array>
#include <cstddef>

#include "calibration/state/state_history.h"

namespace gyrobench::calibration {

// Of one axis, in one interval.
struct FeltAxis {
  // Of a turn of the axis: what the channel turns by [deg per deg].
  double turn = 0.0;
  // Of an angle by which the axis is read wrong all along the interval: what the channel turns by
  // more than the readings say, since the motions of the axes outside of it come from another
  // direction [deg per deg].
  double direction = 0.0;
};

// By stand axis. Of a single-axis reference: that axis of the sensor. All 0 for an orientation.
std::array<FeltAxis, 3> FeelAxes(const StateHistory& history, std::size_t interval,
                                 std::size_t channel);

}  // namespace gyrobench::calibration
