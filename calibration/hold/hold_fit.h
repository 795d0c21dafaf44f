// The joint fit of gyro and accelerometer to held poses.
#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

#include "calibration/hold/hold_model.h"
#include "calibration/hold/hold_start.h"

namespace gyrobench::calibration {

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
