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
// Share of an independent test that one place of a scan adds:
//   b^2 d nu(b sqrt(2 d)),   nu(x) = (2/x) (Phi(x/2) - 1/2) / ((x/2) Phi(x/2) + phi(x/2))
// for a peak of square b^2 = `square`, and d = `apart`, 1 less the correlation of this place's
// statistic with that of the next. Summed over a scan, and one added for its end, it is the chance
// that noise alone makes as high a peak over the chance at one place (Siegmund 1985; Siegmund and
// Yakir 2007). 0 to 1.
double TestsFromNeighbour(double square, double apart);
// x with P(chi^2_degrees > x) = exp(log_p).
double ChiSquareQuantile(double log_p, double degrees);

}  // namespace gyrobench::calibration
