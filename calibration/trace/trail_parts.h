// What the sensor goes through along a trail whose rests, usable intervals and rotations are known.
#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "calibration/trace/trail.h"

namespace gyrobench::calibration {

inline constexpr std::size_t kNoRest = static_cast<std::size_t>(-1);

// Gravity and heading in the sensor's frame: by the reference where it gives an orientation, by the
// accelerometer where one axis turns or none. `rest_of`: index of each node's rest, or kNoRest.
void FillGravity(const Recording& recording, const std::vector<std::size_t>& rest_of, Trail* trail);
// Rates of halves and nodes: size by the reference, shape between its readings by the gyro.
// `units_per_deg_s`: of each channel, NaN where it is not known.
void FillRates(const Recording& recording, const Vector3& units_per_deg_s, Trail* trail);
void FillTemperature(const Recording& recording, Trail* trail);
// Vibration, and the columns `covariates` in this order.
void FillCovariates(const Recording& recording, const std::vector<std::string>& covariates,
                    Trail* trail);

}  // namespace gyrobench::calibration
