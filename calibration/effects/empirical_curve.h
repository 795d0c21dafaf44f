// A curve through knots: straight between them, constant outside.
#pragma once

#include <cstddef>
#include <span>
#include <vector>

namespace gyrobench::calibration {

// The curve is linear in its values at the knots: with other values the same object serves. A jump
// and a flat stretch, which real parts show, are curves of two knots; nothing is extrapolated.
class EmpiricalCurve {
 public:
  // Knots must be finite and grow; throws DataError otherwise, and where there is none.
  explicit EmpiricalCurve(std::vector<double> knots);

  std::size_t size() const { return knots_.size(); }
  // The curve at x, for size() values at the knots; NaN for an x that is NaN.
  double Value(double x, std::span<const double> values) const;

 private:
  // curve(x) = (1 - share) value_i + share value_i+1
  struct Place {
    std::size_t i = 0;
    double share = 0.0;
  };
  Place Find(double x) const;

  std::vector<double> knots_;
};

}  // namespace gyrobench::calibration
