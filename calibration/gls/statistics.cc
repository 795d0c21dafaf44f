#include "calibration/gls/statistics.h"

#include <algorithm>
#include <boost/math/distributions/chi_squared.hpp>
#include <boost/math/distributions/students_t.hpp>
#include <cmath>
#include <limits>

namespace gyrobench::calibration {
namespace {

constexpr double kNormalHalfWidth = 1.959963984540054;
constexpr double kManyDegrees = 1e6;

}  // namespace

double StudentHalfWidth(double degrees) {
  if (!(degrees < kManyDegrees)) return kNormalHalfWidth;
  const boost::math::students_t_distribution<double> student(std::max(degrees, 1.0));
  return boost::math::quantile(student, 0.975);
}

double StudentInflation(double degrees) { return StudentHalfWidth(degrees) / kNormalHalfWidth; }

double WhitenessPValue(std::span<const double> residuals, std::size_t lags) {
  const std::size_t n = residuals.size();
  if (n < 4 * lags) return 1.0;
  double power = 0.0;
  for (const double v : residuals) power += v * v;
  if (!(power > 0)) return 1.0;
  double q = 0.0;
  for (std::size_t lag = 1; lag <= lags; ++lag) {
    double sum = 0.0;
    for (std::size_t i = lag; i < n; ++i) sum += residuals[i] * residuals[i - lag];
    q += (sum / power) * (sum / power) / static_cast<double>(n - lag);
  }
  q *= static_cast<double>(n) * static_cast<double>(n + 2);
  const boost::math::chi_squared_distribution<double> chi(static_cast<double>(lags));
  return boost::math::cdf(boost::math::complement(chi, q));
}

double Mean(std::span<const double> values) {
  double sum = 0.0;
  for (const double v : values) sum += v;
  return sum / static_cast<double>(values.size());
}

double MeanStdError(std::span<const double> values) {
  const auto n = static_cast<double>(values.size());
  if (values.size() < 2) return std::numeric_limits<double>::quiet_NaN();
  const double mean = Mean(values);
  double square = 0.0;
  for (const double v : values) square += (v - mean) * (v - mean);
  return std::sqrt(square / (n - 1.0) / n);
}

}  // namespace gyrobench::calibration
