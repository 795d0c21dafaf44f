// Probabilities and quantiles that selection, diagnostics and intervals of confidence need.
#pragma once

#include <cstddef>
#include <span>

namespace gyrobench::calibration {

// Half-width of the 95 % interval in standard errors: Student's t with `degrees` >= 1 of freedom,
// and the same relative to the normal distribution's (1.96): the factor by which a standard error
// grows so that +-1.96 of it is an honest interval.
double StudentHalfWidth(double degrees);
double StudentInflation(double degrees);

// Probability that independent residuals show serial correlations as large as these over `lags`
// lags (Ljung and Box). 1 where there are too few.
double WhitenessPValue(std::span<const double> residuals, std::size_t lags);

double Mean(std::span<const double> values);
// Standard error of the mean from the scatter. NaN with fewer than two.
double MeanStdError(std::span<const double> values);

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
