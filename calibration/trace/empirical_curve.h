// A smooth curve through knots: natural cubic spline, constant slope outside the knots.
#pragma once

#include <cstddef>
#include <span>
#include <vector>

namespace gyrobench::calibration {

// The curve is linear in its values at the knots: with other values the same object serves. One
// knot is a constant, two are a straight line.
class EmpiricalCurve {
 public:
  // Knots must be finite and grow; throws DataError otherwise, and where there is none.
  explicit EmpiricalCurve(std::vector<double> knots);

  std::size_t size() const { return knots_.size(); }
  const std::vector<double>& knots() const { return knots_; }
  // weights[i], size() of them, with  curve(x) = sum_i weights[i] value_i : the cardinal splines at
  // x. NaN for an x that is NaN.
  void Weights(double x, double* weights) const;
  // The curve at x, for size() values at the knots.
  double Value(double x, std::span<const double> values) const;

 private:
  // curve(x) = at_low value_i + at_high value_i+1 + slope_low slope_i + slope_high slope_i+1.
  struct Place {
    std::size_t i = 0;
    double at_low = 1.0, at_high = 0.0, slope_low = 0.0, slope_high = 0.0;
  };
  Place Find(double x) const;
  // slope of the curve at knot i = sum_j Slope(i, j) value_j
  double Slope(std::size_t i, std::size_t j) const { return slopes_[i * knots_.size() + j]; }

  std::vector<double> knots_;
  std::vector<double> slopes_;  // row-major, knots x knots
};

}  // namespace gyrobench::calibration
