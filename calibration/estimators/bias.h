// Zero-rate offset against temperature.
#pragma once

#include <string>
#include <vector>

#include "calibration/estimators/results.h"
#include "calibration/estimators/schedule.h"

namespace gyrobench::calibration {

// One result for each usable channel, from the rests alone. Joint estimate by generalised least
// squares:
//   output = beta(T) + random walk + noise,   beta(T) = sum c_j (T - mean)^j
// order by BIC, noise by REML; the random walk is 0 at the first rest. Next to it the paper's
// estimate. Earth's rotation is taken off where latitude and orientation are known. `scale`: the
// scale factors of the same measurement, for the output's unit; nominal where there is none.
// Rests in which the gyro turns are left out and added to `defects`.
std::vector<BiasResult> EstimateBias(const Estimation& estimation,
                                     const std::vector<ScaleResult>& scale,
                                     std::vector<std::string>* remarks,
                                     std::vector<Defect>* defects);

}  // namespace gyrobench::calibration
