#include "calibration/effects/empirical_curve.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "base/error.h"

namespace gyrobench::calibration {

EmpiricalCurve::EmpiricalCurve(std::vector<double> knots) : knots_(std::move(knots)) {
  if (knots_.empty()) throw DataError("a curve needs at least one knot");
  for (std::size_t i = 0; i < knots_.size(); ++i) {
    if (!std::isfinite(knots_[i]) || (i > 0 && !(knots_[i] > knots_[i - 1]))) {
      throw DataError(
          fmt::format("knots of a curve must be finite and grow, knot {} is {}", i + 1, knots_[i]));
    }
  }
}

EmpiricalCurve::Place EmpiricalCurve::Find(double x) const {
  if (std::isnan(x)) return {0, x};
  if (!(x > knots_.front())) return {0, 0.0};
  if (x >= knots_.back()) return {knots_.size() - 1, 0.0};
  const auto above = std::upper_bound(knots_.begin(), knots_.end(), x);
  const auto i = static_cast<std::size_t>(above - knots_.begin()) - 1;
  return {i, (x - knots_[i]) / (knots_[i + 1] - knots_[i])};
}

double EmpiricalCurve::Value(double x, std::span<const double> values) const {
  const Place place = Find(x);
  if (place.share == 0.0) return values[place.i];
  if (place.i + 1 == size()) return place.share;  // NaN with one knot
  return (1.0 - place.share) * values[place.i] + place.share * values[place.i + 1];
}

}  // namespace gyrobench::calibration
