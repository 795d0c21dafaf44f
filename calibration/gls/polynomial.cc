#include "calibration/gls/polynomial.h"

#include <Eigen/QR>
#include <cmath>

namespace gyrobench::calibration {

// u = (x + d) / h with x = T - reference, d = reference - middle:
//   u^k = h^-k sum_j binomial(k, j) d^(k-j) x^j
std::vector<double> ToPowersOf(const TemperatureScale& scale, double reference_degC,
                               std::size_t n) {
  std::vector<double> l(n * n, 0.0);
  const double d = reference_degC - scale.middle_degC;
  for (std::size_t k = 0; k < n; ++k) {
    double binomial = 1.0;
    for (std::size_t j = k + 1; j-- > 0;) {
      // binomial(k, k), binomial(k, k - 1), ...
      l[j * n + k] = binomial * std::pow(d, static_cast<double>(k - j)) /
                     std::pow(scale.half_degC, static_cast<double>(k));
      binomial *= static_cast<double>(j) / static_cast<double>(k - j + 1);
    }
  }
  return l;
}

std::vector<double> Transformed(const std::vector<double>& l, const std::vector<double>& a) {
  const std::size_t n = a.size();
  std::vector<double> out(n, 0.0);
  for (std::size_t i = 0; i < n; ++i) {
    for (std::size_t j = 0; j < n; ++j) out[i] += l[i * n + j] * a[j];
  }
  return out;
}

std::vector<double> TransformedCovariance(const std::vector<double>& l,
                                          const std::vector<double>& c, std::size_t n) {
  std::vector<double> half(n * n, 0.0), out(n * n, 0.0);
  for (std::size_t i = 0; i < n; ++i) {
    for (std::size_t j = 0; j < n; ++j) {
      for (std::size_t k = 0; k < n; ++k) half[i * n + j] += l[i * n + k] * c[k * n + j];
    }
  }
  for (std::size_t i = 0; i < n; ++i) {
    for (std::size_t j = 0; j < n; ++j) {
      for (std::size_t k = 0; k < n; ++k) out[i * n + j] += half[i * n + k] * l[j * n + k];
    }
  }
  return out;
}

double Evaluate(std::span<const double> coefficients, double x) {
  double sum = 0.0;
  for (std::size_t i = coefficients.size(); i-- > 0;) sum = sum * x + coefficients[i];
  return sum;
}

PolynomialFit FitPolynomial(std::span<const double> u, std::span<const double> y,
                            std::size_t order) {
  const auto n = static_cast<Eigen::Index>(u.size());
  const auto p = static_cast<Eigen::Index>(order + 1);
  Eigen::MatrixXd design(n, p);
  for (Eigen::Index i = 0; i < n; ++i) {
    double power = 1.0;
    for (Eigen::Index j = 0; j < p; ++j, power *= u[static_cast<std::size_t>(i)])
      design(i, j) = power;
  }
  const Eigen::Map<const Eigen::VectorXd> output(y.data(), n);
  const Eigen::VectorXd a = design.householderQr().solve(output);
  PolynomialFit fit;
  fit.coefficients.assign(a.data(), a.data() + p);
  fit.residual_square = (output - design * a).squaredNorm();
  return fit;
}

}  // namespace gyrobench::calibration
