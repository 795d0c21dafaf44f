// Probabilities of what selection and diagnostics test.
#pragma once

#include <Eigen/Core>

namespace gyrobench::calibration {

// Natural logarithm of P(chi^2_degrees > x); finite however large x is.
double LogChiSquareTail(double x, double degrees);
// x with P(chi^2_degrees > x) = exp(log_p).
double ChiSquareQuantile(double log_p, double degrees);

}  // namespace gyrobench::calibration
