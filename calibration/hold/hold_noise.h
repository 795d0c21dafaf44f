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
// recording does not say stays near what such parts show: bias random walk 1e-4 deg/s/sqrt(s)
// (MPU-6050 class) within a factor 4, stillness 2 within a factor 4, one standard deviation each.
HoldNoise EstimateNoise(const LinearModel& model, const HoldNoise& start);

// From the rests.
HoldNoise StartNoise(const RestNoise& rests);

}  // namespace gyrobench::calibration
