// The noise of held poses by restricted maximum likelihood, and what its own error adds to that of
// the parameters.
#pragma once

#include "calibration/hold/hold_model.h"
#include "calibration/hold/hold_noise.h"

namespace gyrobench::calibration {

// Angle random walk, bias random walk, scatter from pose to pose and stillness for which the linear
// model is likeliest by the restricted likelihood (Patterson and Thompson 1971); the
// accelerometer's density is the rests' own and stays. What a short recording does not say stays
// near what such parts show (MPU-6050, data sheet): angle random walk 0.0035 deg/sqrt(s), or what
// the highest frequencies of the rests show where that is more, bias random walk
// 1e-4 deg/s/sqrt(s), stillness 2, each within a factor 4 (one standard deviation). In a hand the
// accelerometer's noise hides the gyro's, and without this it would be found to be 0.
HoldNoise EstimateNoise(const LinearModel& model, const HoldNoise& start);

// From the rests.
HoldNoise StartNoise(const RestNoise& rests);

// Mean square error of the parameters, then of the mean of the zero-rate offset over the rests
// [rad/s], where the noise is known no better than the model's data tell it. By the law of total
// variance it is the mean of the covariance over all noise that these data permit, and of what the
// estimate would move by from the one at `noise`, which is reported:
//   C = E[C(noise) + x(noise) x(noise)^T],
// over the posterior of the four logarithms, by importance sampling (Geweke 1989) from Student's
// distribution about `noise`, the likeliest, at the same points of a Sobol sequence each time. Few
// turns tell the noise to a factor 2 only: by the likeliest noise alone, errors are too small
// whenever that noise is too small. The accelerometer's density is taken as known. NaN where the
// model determines nothing.
Eigen::MatrixXd CovarianceOverNoise(const LinearModel& model, const HoldNoise& noise);

}  // namespace gyrobench::calibration
