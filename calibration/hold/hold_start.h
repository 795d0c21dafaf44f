// Where the fit of held poses begins, and what the rests alone say of the noise.
#pragma once

#include <Eigen/Core>
#include <optional>

#include "calibration/hold/hold_model.h"

namespace gyrobench::calibration {

// Accelerometer from |g| = 1 by a sphere through the rests' means; the gyro's matrix as nominal
// (`units_per_deg_s`) or from the turns themselves, whichever leaves less: while gravity turns
// through the sensor, d g = g x (A dz), linear in A, which needs neither sensitivity nor the right
// order or sign of axes. `offset`: of the gyro, output units. nullopt where neither is to be had.
std::optional<HoldState> StartState(const HeldChain& chain, const Eigen::Vector3d& offset,
                                    std::optional<double> units_per_deg_s);

// Of the rests alone; nothing is known where none is long enough.
RestNoise NoiseWithinRests(const HeldChain& chain, const HoldState& state);

// |g_{k+1} - R^T g_k| of each turn [rad]; NaN of links that are no turn.
std::vector<double> TurnMisses(const HeldChain& chain, const HoldState& state);

}  // namespace gyrobench::calibration
