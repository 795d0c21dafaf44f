// The few distributions that the estimators need.
#pragma once

#include <cstddef>
#include <span>

namespace gyrobench::calibration {

// Half-width of the 95 % interval in standard errors: Student's t with `degrees` >= 1 of freedom,
// and the same relative to the normal distribution's (1.96): the factor by which a standard error
// grows so that
// +-1.96 of it is an honest interval.
double StudentHalfWidth(double degrees);
double StudentInflation(double degrees);

// Probability that independent residuals show serial correlations as large as these over `lags`
// lags (Ljung and Box). 1 where there are too few.
double WhitenessPValue(std::span<const double> residuals, std::size_t lags);

double Mean(std::span<const double> values);
// Standard error of the mean from the scatter. NaN with fewer than two.
double MeanStdError(std::span<const double> values);

}  // namespace gyrobench::calibration
