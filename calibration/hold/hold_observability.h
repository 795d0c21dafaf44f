// What the poses and turns show, and what they do not.
#pragma once

#include <string>
#include <vector>

#include "calibration/hold/hold_noise.h"
#include "calibration/hold/hold_result.h"

namespace gyrobench::calibration {

// The six directions by the rests of the state.
std::vector<HoldFace> FacesOf(const HoldState& state);

// By how much the sensor turned about each of its axes [deg], the way there and the way back added.
std::array<double, 3> TurnedAbout(const HeldChain& chain, const HoldState& state);

// Why there can be no calibration, in sentences that say what to do; empty where there can be one.
// Judged by the standard errors that the poses permit at the rests' noise: an element of the gyro's
// or the accelerometer's matrix, or the accelerometer's offset in g, that stays beyond 3 % (what a
// data sheet says without any measurement) is not known.
std::vector<std::string> WhatIsMissing(const HeldChain& chain, const HoldState& state,
                                       const HoldNoise& noise);

}  // namespace gyrobench::calibration
