// From the channels' fits to one sensor.
#pragma once

#include <span>

#include "calibration/sensor/channel_row.h"
#include "calibration/sensor/vector_calibration.h"
#include "calibration/state/state_history.h"

namespace gyrobench::calibration {

// `rows`: of the channels that were traced. The noise of channels is taken as independent: of the
// reference's, which they share, each feels what turns about its own axis. That holds of turns
// about one sensor axis; where an axis of the stand lies between two of the sensor's, both feel its
// encoder.
VectorCalibration MakeVectorCalibration(std::span<const ChannelRow> rows,
                                        std::span<const StateHistory> histories);

// Without the accelerometer.
VectorCalibration JoinChannels(std::span<const ChannelRow> rows);

}  // namespace gyrobench::calibration
