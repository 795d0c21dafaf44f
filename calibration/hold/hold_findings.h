// What is left beyond matrix and offset, and the verdict.
#pragma once

#include <vector>

#include "calibration/hold/hold_fit.h"
#include "calibration/hold/hold_result.h"

namespace gyrobench::calibration {

// False once in so many sets, each of the tests: three rows of the g-sensitivity together below one
// in a hundred sets, with room for the noise being estimated.
inline constexpr double kSeen = 1e-3;

// One for each channel whose row of the g-sensitivity is not zero; `fit` has it in its model.
std::vector<HoldFinding> GSensitivitySeen(const HoldFit& fit);

// Scale factors that change with the rate or with its sign, an accelerometer that is not straight,
// turns that scatter more than the noise within rests explains, means of rests that do.
std::vector<HoldFinding> WhatIsLeft(const HeldChain& chain, const HoldFit& fit,
                                    const RestNoise& rests, double latitude_rad);

}  // namespace gyrobench::calibration
