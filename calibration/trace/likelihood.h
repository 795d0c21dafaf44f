// Probabilities of what selection and diagnostics test.
#pragma once

#include <Eigen/Core>

namespace gyrobench::calibration {

// Natural logarithm of P(chi^2_degrees > x); finite however large x is.
double LogChiSquareTail(double x, double degrees);
// The same for the square of one value of Student's distribution, scaled to unit variance, with
// `freedom` degrees, more than 2; infinity: of a normal one.
double LogHeavyTail(double square, double freedom);
// Degrees of freedom of Student's distribution of unit variance that has so many of the values
// beyond three standard deviations, at least 4.5; infinity where as many normal values may be
// there.
double FreedomOfTails(double beyond_three, double values);
// How many independent tests are worth a scan whose highest peak's square is `square`: the chance
// that chance alone makes one as high, over that at one place (Siegmund 1985; Siegmund and Yakir
// 2007). `apart`: of one place and the next, 1 less their correlation.
double TestsFromNeighbour(double square, double apart);
// x with P(chi^2_degrees > x) = exp(log_p).
double ChiSquareQuantile(double log_p, double degrees);

}  // namespace gyrobench::calibration
