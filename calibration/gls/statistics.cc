#include "calibration/gls/statistics.h"

#include <algorithm>
#include <boost/math/distributions/chi_squared.hpp>
#include <boost/math/distributions/normal.hpp>
#include <boost/math/distributions/students_t.hpp>
#include <boost/math/special_functions/gamma.hpp>
#include <boost/math/tools/toms748_solve.hpp>
#include <cmath>
#include <cstdint>
#include <limits>

namespace gyrobench::calibration {
namespace {

constexpr double kNormalHalfWidth = 1.959963984540054;
constexpr double kManyDegrees = 1e6;

// Where a function that falls from `low` to `high` is `value`; the end that is nearer where it is
// nowhere. NaN of NaN.
template <typename Function>
double FallsTo(double value, double low, double high, const Function& function) {
  const auto above = [&](double x) { return function(x) - value; };
  const double at_low = above(low), at_high = above(high);
  if (std::isnan(at_low) || std::isnan(at_high)) return std::numeric_limits<double>::quiet_NaN();
  if (!(at_low > 0.0)) return low;
  if (!(at_high < 0.0)) return high;
  std::uintmax_t most = 100;
  const auto [from, to] = boost::math::tools::toms748_solve(
      above, low, high, at_low, at_high, boost::math::tools::eps_tolerance<double>(), most);
  return 0.5 * (from + to);
}

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

double LogChiSquareTail(double x, double degrees) {
  if (!(x > 0)) return 0.0;
  if (std::isinf(x)) return -x;
  if (x < 600.0) {
    const boost::math::chi_squared distribution(degrees);
    return std::log(boost::math::cdf(boost::math::complement(distribution, x)));
  }
  // Leading terms of the incomplete gamma function for large x. That of the C library writes the
  // sign to a variable that all threads share.
  const double half = 0.5 * x, a = 0.5 * degrees;
  return (a - 1.0) * std::log(half) - half - boost::math::lgamma(a) + std::log1p((a - 1.0) / half);
}

double LogHeavyTail(double square, double freedom) {
  if (!std::isfinite(freedom) || std::isinf(square)) return LogChiSquareTail(square, 1.0);
  const boost::math::students_t distribution(freedom);
  const double t = std::sqrt(std::max(square, 0.0) * freedom / (freedom - 2.0));
  return std::log(2.0 * boost::math::cdf(boost::math::complement(distribution, t)));
}

double FreedomOfTails(double beyond_three, double values) {
  constexpr double kSure = 4.0;
  const double normal = values * std::exp(LogChiSquareTail(9.0, 1.0));
  if (!(beyond_three > normal + kSure * std::sqrt(normal)))
    return std::numeric_limits<double>::infinity();
  const double log_share = std::log(beyond_three / values);
  return FallsTo(log_share, 4.5, 100.0, [](double freedom) { return LogHeavyTail(9.0, freedom); });
}

double TestsFromNeighbour(double square, double apart) {
  const double half = std::sqrt(0.5 * apart * square);
  if (half < 1e-6) return square * apart;
  const boost::math::normal normal;
  const double below = boost::math::cdf(normal, half);
  const double overshoot = (below - 0.5) / half / (half * below + boost::math::pdf(normal, half));
  return std::min(1.0, square * apart * overshoot);
}

double ChiSquareQuantile(double log_p, double degrees) {
  double high = 10.0;
  while (LogChiSquareTail(high, degrees) > log_p) high *= 2.0;
  return FallsTo(log_p, 0.0, high, [&](double x) { return LogChiSquareTail(x, degrees); });
}

}  // namespace gyrobench::calibration
