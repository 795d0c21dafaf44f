// From a fit to the numbers that leave the bench.
#pragma once

#include "calibration/hold/hold_fit.h"
#include "calibration/hold/hold_result.h"

namespace gyrobench::calibration {

// Fills unit, sensitivity, offset, matrices with covariance, noise and the channels of the
// calibration file. `seen`: which rows of the g-sensitivity the calibration takes off.
void FillResult(const HeldChain& chain, const HoldFit& fit, const RestNoise& rests,
                std::array<bool, 3> seen, HoldResult* out);

}  // namespace gyrobench::calibration
