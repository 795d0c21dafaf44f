// The noise of held poses by restricted maximum likelihood.
#pragma once

#include "calibration/hold/hold_model.h"
#include "calibration/hold/hold_start.h"

namespace gyrobench::calibration {

// -2 log of the restricted likelihood, all unknowns integrated out (Patterson and Thompson 1971):
//   sum of rows log v + log det H + residual^T V^-1 residual.  NaN where H is singular.
double RestrictedDeviance(const LinearModel& model, const HoldNoise& noise);

// Angle random walk, bias random walk, scatter from pose to pose and stillness for which the linear
// model is likeliest; the accelerometer's density is the rests' own and stays. What a short
// recording does not say stays near what such parts show (MPU-6050, data sheet): angle random walk
// 0.0035 deg/sqrt(s), bias random walk 1e-4 deg/s/sqrt(s), stillness 2, each within a factor 4 (one
// standard deviation). In a hand the accelerometer's noise hides the gyro's, which would else be
// found 0.
HoldNoise EstimateNoise(const LinearModel& model, const HoldNoise& start);

// From the rests.
HoldNoise StartNoise(const RestNoise& rests);

}  // namespace gyrobench::calibration
