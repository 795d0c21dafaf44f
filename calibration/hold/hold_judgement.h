// What is said of held poses and their fit: what poses and turns show, what cannot be and is
// likelier wrong than the part, what is left beyond matrix and offset, and the numbers that leave
// the bench.
#pragma once

#include <string>
#include <vector>

#include "calibration/hold/calibrate_hold.h"
#include "calibration/hold/hold_fit.h"
#include "calibration/hold/hold_model.h"

namespace gyrobench::calibration {

// The six directions by the rests of the state.
std::vector<HoldFace> FacesOf(const HoldState& state);

// By how much the sensor turned about each of its axes [deg], the way there and the way back added.
std::array<double, 3> TurnedAbout(const HeldChain& chain, const HoldState& state);

// Why there can be no calibration, in sentences that say what to do; empty where there can be one.
// Judged by the standard errors that the poses permit at the rests' noise: an element of the gyro's
// or the accelerometer's matrix, or the accelerometer's offset in g, that stays beyond what the
// data sheet says without any measurement (kScaleOfDataSheet) is not known.
std::vector<std::string> WhatIsMissing(const HeldChain& chain, const HoldState& state,
                                       const HoldNoise& noise);

// A sentence for each sensor whose scale is off by more than that of any MEMS part: what was found,
// the likeliest cause, what to check. Empty where all can be. `info`: of the measurements; where it
// says no sensitivity of the gyro there is nothing to compare its scale with.
std::vector<std::string> ImplausibleHold(const HoldState& state, const MeasurementInfo& info);

// False once in so many sets, each of the tests: three rows of the g-sensitivity together below one
// in a hundred sets, with room for the noise being estimated.
inline constexpr double kSeen = 1e-3;

// One for each channel whose row of the g-sensitivity is not zero; `fit` has it in its model.
std::vector<HoldFinding> GSensitivitySeen(const HoldFit& fit);

// Scale factors that change with the rate or with its sign, an accelerometer that is not straight,
// turns that scatter more than the noise within rests explains, means of rests that do.
std::vector<HoldFinding> WhatIsLeft(const HeldChain& chain, const HoldFit& fit,
                                    const RestNoise& rests, double latitude_rad);

// Fills unit, sensitivity, offset, matrices with covariance, noise and the channels of the
// calibration file. `seen`: which rows of the g-sensitivity the calibration takes off.
void FillResult(const HeldChain& chain, const HoldFit& fit, const RestNoise& rests,
                std::array<bool, 3> seen, HoldResult* out);

}  // namespace gyrobench::calibration
