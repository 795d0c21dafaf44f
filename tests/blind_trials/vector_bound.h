// What the Cramer-Rao bound permits of a channel's row of M, b(T) and g-sensitivity, from the stand
// and the noise alone: no part of the tracer.
#pragma once

#include <Eigen/Core>
#include <array>

#include "tests/blind_trials/trial.h"

namespace gyrobench::blind_trials {

inline constexpr Eigen::Index kBiasTerms = 4;
// Of the covariance: M about x, y, z; b_0 .. b_3; g-sensitivity along x, y, z.
inline constexpr Eigen::Index kRowParameters = 10;
using RowCovariance = Eigen::Matrix<double, kRowParameters, kRowParameters>;

// R_mount: rotates vectors of the sensor's frame into that of the inner axis.
Eigen::Matrix3d MountOf(const TrialSpec& spec);

// Covariance at the bound of each channel's parameters, with b(T) about `reference_degC`. The
// sequence is simulated without noise. Its rotations, integrals of (T - T0)^k and of gravity pass a
// Kalman filter of angle and bias, in which an angle of the reference has its noise, and a stretch
// in which nothing turns that the channel feels has one angle: the mean of its readings. The filter
// takes noise as normal and 1/f noise as none. About the axes as the recording says they are
// mounted.
std::array<RowCovariance, 3> VectorBound(const TrialSpec& spec, double reference_degC);

}  // namespace gyrobench::blind_trials
