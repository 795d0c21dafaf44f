// Noise of a measurement of held poses. All are standard deviations; NaN: not known.
#pragma once

#include "base/measurement.h"
#include "calibration/gls/noise_model.h"

namespace gyrobench::calibration {

// Of the joint fit of gyro and accelerometer.
struct HoldNoise : GyroNoise {
  double accel_density_g_sqrt_s = kMissing;  // of the mean of a rest, over the root of its length
  double pose_scatter_g = kMissing;          // of a rest's mean beyond that
  double stillness = kMissing;  // of a rest's turning, over what the sensor trembles by in it
  double usual_angle_random_walk_deg_sqrt_s = kMissing;  // centre of its prior
};

// What is told of it, beside the rests' own.
struct HoldNoiseResult : HoldNoise {
  double rest_angle_random_walk_deg_sqrt_s = kMissing;  // within them alone; a tremble is in it
};

// Angle random walk and the accelerometer's density from the scatter of means over 0.4 s within the
// rests, about a straight line each. A hand's tremble can only make the random walk larger.
struct RestNoise {
  double angle_random_walk_deg_sqrt_s = kMissing;         // of the quietest fifth
  double median_angle_random_walk_deg_sqrt_s = kMissing;  // of the median rest
  // By what is near half the sample rate, where no hand trembles: of 80 samples a second or more. A
  // low-pass filter of the sensor makes it smaller than it is.
  double white_angle_random_walk_deg_sqrt_s = kMissing;
  double accel_density_g_sqrt_s = kMissing;
};

}  // namespace gyrobench::calibration
