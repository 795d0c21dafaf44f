#include "calibration/trace/likelihood.h"

#include <boost/math/distributions/chi_squared.hpp>
#include <cmath>

namespace gyrobench::calibration {

double LogChiSquareTail(double x, double degrees) {
  if (!(x > 0)) return 0.0;
  if (x < 600.0) {
    const boost::math::chi_squared distribution(degrees);
    return std::log(boost::math::cdf(boost::math::complement(distribution, x)));
  }
  // Leading terms of the incomplete gamma function for large x.
  const double half = 0.5 * x, a = 0.5 * degrees;
  return (a - 1.0) * std::log(half) - half - std::lgamma(a) + std::log1p((a - 1.0) / half);
}

double ChiSquareQuantile(double log_p, double degrees) {
  double low = 0.0, high = 10.0;
  while (LogChiSquareTail(high, degrees) > log_p) high *= 2.0;
  for (int i = 0; i < 60; ++i) {
    const double middle = 0.5 * (low + high);
    (LogChiSquareTail(middle, degrees) > log_p ? low : high) = middle;
  }
  return high;
}

}  // namespace gyrobench::calibration
