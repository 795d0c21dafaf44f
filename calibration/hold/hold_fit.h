// The joint fit of gyro and accelerometer to held poses, and their noise by restricted maximum
// likelihood.
#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

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

// A turn or a rest that does not belong to the others.
struct Misfit {
  FactorKind kind = FactorKind::kTurn;
  std::size_t index = 0;    // of the chain's links or rests
  double chi_square = 0.0;  // by which the fit gets better without it
  int degrees = 2;
};

struct HoldFit {
  HoldState state;
  HoldNoise noise;
  ModelExtent extent;
  LinearModel model;  // at the state
  ArrowSystem::Solution solution;
  bool converged = false;
  // Each turn and each rest's mean acceleration as the others predict it, whitened: root mean
  // square, 1 where the noise explains it.
  double turn_whitened_rms = kMissing, accel_whitened_rms = kMissing;
  std::vector<Misfit> left_out;
};

// Gauss-Newton from `start`, noise between its rounds, with g-sensitivity in the model so that a
// missing one does not inflate the noise. Turns and rests that the others contradict beyond one in
// a thousand sets are left out, one by one, a fifth of them at most.
HoldFit FitHeldPoses(const HeldChain& chain, const HoldState& start, const HoldNoise& noise,
                     double latitude_rad);

// The same data and noise with another extent of the model.
HoldFit Refit(const HeldChain& chain, const HoldFit& fit, const ModelExtent& extent,
              double latitude_rad);

// Of columns first .. first + count - 1 of the parameters, all zero in truth: chi square of their
// estimate by a model with them, at the state of `fit`.
struct WaldTest {
  Eigen::VectorXd values, std_errors;
  double chi_square = 0.0;
  double p_value = 1.0;
};
WaldTest TestColumns(const ArrowSystem::Solution& solution, const Eigen::VectorXd& at,
                     const std::vector<Eigen::Index>& columns, double degrees_of_noise);

// Degrees of freedom that the noise of turns is known by: two a turn less the gyro's matrix.
double TurnFreedom(const HoldFit& fit);

}  // namespace gyrobench::calibration
