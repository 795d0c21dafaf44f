// The model of held poses, and its residuals at a state.
//
// Rest k begins with gravity g_k (unit vector in N) and turns by the small delta_k [rad] while it
// lasts, about its own axes; the zero-rate offset goes from beta_begin to beta_end. N is the
// accelerometer's own frame, the one nearest to its three axes. Measured are, for each rest,
//   accel   = T g_middle + offset                     mean of the accelerometer [g]
//   int y   = M delta + (beta_begin + beta_end) T/2 + (M e_S + G g) T    [rad]
// and for each turn that g_{k+1} = R^T exp(-delta_k) g_k, with R the integral of the gyro's rate
// (turn_rotation.h) and the Earth's e. What a rest's mean says is shared by the turn before and the
// one after: gravity and offset of every rest are unknowns, so that no covariance is left out.
#pragma once

#include <Eigen/Core>
#include <array>
#include <vector>

#include "calibration/hold/arrow_system.h"
#include "calibration/hold/held_rest.h"
#include "calibration/hold/hold_noise.h"
#include "calibration/hold/turn_rotation.h"

namespace gyrobench::calibration {

// accel = T g + offset, T = diag(scale) S: S symmetric, its rows the unit vectors of the sensitive
// axes, off its diagonal `shear` for yz, zx, xy (half the non-orthogonality, to first order).
struct AccelParameters {
  Eigen::Vector3d scale = Eigen::Vector3d::Ones();
  Eigen::Vector3d shear = Eigen::Vector3d::Zero();
  Eigen::Vector3d offset_g = Eigen::Vector3d::Zero();

  Eigen::Matrix3d Directions() const;  // S
  Eigen::Matrix3d Matrix() const { return scale.asDiagonal() * Directions(); }
};

struct NodeState {
  Eigen::Vector3d gravity = Eigen::Vector3d::UnitZ();
  Eigen::Vector3d delta = Eigen::Vector3d::Zero();
  Eigen::Vector3d beta_begin = Eigen::Vector3d::Zero(), beta_end = Eigen::Vector3d::Zero();
};

struct HoldState {
  double unit = 1.0;  // rad/s per unit of xi
  Eigen::Matrix3d m = Eigen::Matrix3d::Identity();
  Eigen::Matrix3d g_sensitivity = Eigen::Matrix3d::Zero();  // rad/s/g
  AccelParameters accel;
  Eigen::Vector3d earth = Eigen::Vector3d::Zero();  // rad/s; frame: level at the first rest, z up
  std::vector<NodeState> nodes;

  GyroParameters Gyro() const;
};

// Order of the parameters. What follows the first kBase is asked for one by one.
enum ParameterAt : Eigen::Index {
  kAtM = 0,
  kAtScale = 9,
  kAtShear = 12,
  kAtOffset = 15,
  kAtEarth = 18,
  kBase = 21,
};

// What the model has besides.
struct ModelExtent {
  bool g_sensitivity = false;  // 9, row by row
  bool bent_gyro = false;      // 9: |w|, w^2, w |w| over 1 rad/s of each channel
  bool bent_accel = false;     // 6: a^2, a^3 of each axis

  Eigen::Index AtGSensitivity() const { return kBase; }
  Eigen::Index AtBentGyro() const { return kBase + (g_sensitivity ? 9 : 0); }
  Eigen::Index AtBentAccel() const { return AtBentGyro() + (bent_gyro ? 9 : 0); }
  Eigen::Index Parameters() const { return AtBentAccel() + (bent_accel ? 6 : 0); }
};

enum class FactorKind { kAccel, kGyro, kStill, kRestWalk, kTurn, kLinkWalk };

// Rows of equal variance that belong together.
struct HoldFactor {
  FactorKind kind = FactorKind::kAccel;
  Eigen::Index node = 0;  // the first of two for kTurn and kLinkWalk
  Eigen::Index rows = 3;
  double duration_s = 0.0;
  double path = 0.0;  // [rad], kStill: what the sensor trembles by
  ArrowSystem::Products products;
  bool used = true;
};

struct LinearModel {
  ModelExtent extent;
  Eigen::Index nodes = 0;
  std::vector<HoldFactor> factors;
  // Prior of the Earth's rate in the state's frame, from where it is now.
  std::array<double, 3> earth_value = {}, earth_weight = {};
};

// At this state. `latitude_rad`: NaN where the site is not known.
LinearModel Linearize(const HeldChain& chain, const HoldState& state, const ModelExtent& extent,
                      double latitude_rad);

// Of one row.
double VarianceOf(const HoldFactor& factor, const HoldNoise& noise);

ArrowSystem::Solution SolveModel(const LinearModel& model, const HoldNoise& noise);
// The same with three functionals: the mean of the zero-rate offset over the rests [rad/s].
ArrowSystem::Solution SolveWithMeanOffset(const LinearModel& model, const HoldNoise& noise);
// What a solution changes that mean by [rad/s].
Eigen::Vector3d MeanOffsetOf(const ArrowSystem::Solution& step);

// The state moved by a solution.
void Move(const ArrowSystem::Solution& step, const ModelExtent& extent, HoldState* state);

}  // namespace gyrobench::calibration
