// Polynomials of temperature in a variable that keeps them well conditioned.
#pragma once

#include <span>
#include <vector>

namespace gyrobench::calibration {

// u = (T - middle) / half: -1..1 over the range of temperature.
struct TemperatureScale {
  double middle_degC = 0.0;
  double half_degC = 1.0;
  double u(double temperature_degC) const { return (temperature_degC - middle_degC) / half_degC; }
};

// sum_k a_k u^k = sum_j c_j (T - reference)^j with c = L a: L, n x n, row-major.
std::vector<double> ToPowersOf(const TemperatureScale& scale, double reference_degC, std::size_t n);

// L a, and L C L^T for a covariance C (n x n, row-major).
std::vector<double> Transformed(const std::vector<double>& l, const std::vector<double>& a);
std::vector<double> TransformedCovariance(const std::vector<double>& l,
                                          const std::vector<double>& c, std::size_t n);

double Evaluate(std::span<const double> coefficients, double x);

// Ordinary least squares of y on 1, u, ..., u^order.
struct PolynomialFit {
  std::vector<double> coefficients;
  double residual_square = 0.0;
};
PolynomialFit FitPolynomial(std::span<const double> u, std::span<const double> y,
                            std::size_t order);

}  // namespace gyrobench::calibration
