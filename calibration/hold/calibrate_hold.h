// A calibration without a stand: held poses with turns by hand between them.
#pragma once

#include <span>

#include "calibration/hold/epoch.h"
#include "calibration/hold/hold_result.h"

namespace gyrobench::calibration {

struct HoldOptions {
  // The g-sensitivity stays in the model whether it is seen or not.
  bool g_sensitivity = false;
};

// Gyro matrix, offset, g-sensitivity and the accelerometer's own calibration from rests and turns;
// gravity is the reference, and time stamps give the scale. What these poses do not show is said in
// `missing`, and no number is given then. Throws DataError where there is nothing to work with: no
// three axes of gyro or accelerometer, no sample, data of different sensors.
HoldResult CalibrateHold(std::span<const HoldRecording* const> recordings,
                         const HoldOptions& options = {});

}  // namespace gyrobench::calibration
