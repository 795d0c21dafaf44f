// Scale factor of each axis that turned.
#pragma once

#include <array>
#include <string>
#include <vector>

#include "calibration/estimators/results.h"
#include "calibration/estimators/schedule.h"

namespace gyrobench::calibration {

// One result for each usable channel whose axis turned enough; for the others a remark says why
// not, and `unfollowed_deg` by how much the axis turned where the output did not follow. Turns and
// rests in which gyro and reference contradict each other are left out and added to `defects`.
//
// Joint estimate by generalised least squares (interval_gls.h), y the integral of the output over
// an interval in nominal deg:
//   y = M dphi + sum_j M_j dphi_j + (B + B1 (T - mean) + ...) dt
//   alpha = 1 / (M x units per deg/s)
// with dphi_j the rotation about the other axes where they turned too, and the order of the bias's
// dependence on temperature by BIC. `bias` is the mean over the measurement, random walk included.
// Standard errors allow for the noise having been estimated (Student's t), for the time base where
// the unit's clock was measured, and, where the whitened residuals are not white, for that (block
// sandwich).
std::vector<ScaleResult> EstimateScale(const Estimation& estimation,
                                       std::vector<std::string>* remarks,
                                       std::array<double, 3>* unfollowed_deg,
                                       std::vector<Defect>* defects);

// Remark where the whitened residuals are not white: white ones are as far from it with probability
// `p_white`, and the standard error is `grown` times that of the model. A growth by less than a
// twentieth is not worth saying.
std::string RemarkOnStructure(double p_white, double grown);

}  // namespace gyrobench::calibration
