#include "calibration/trace/empirical_curve.h"

#include <fmt/format.h>

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <utility>

#include "base/error.h"

namespace gyrobench::calibration {
namespace {

void Check(const std::vector<double>& knots) {
  if (knots.empty()) throw DataError("a curve without knots: expected at least one");
  for (std::size_t i = 0; i < knots.size(); ++i) {
    const bool grows = i == 0 || knots[i] > knots[i - 1];
    if (std::isfinite(knots[i]) && grows) continue;
    throw DataError(
        fmt::format("knot {} of a curve is {}: expected finite knots that grow", i, knots[i]));
  }
}

// The slopes d of the natural spline through (x_i, v_i), h_i = x_i+1 - x_i (de Boor 1978, ch. IV):
//   2 d_0 + d_1 = 3 (v_1 - v_0) / h_0                                    (second derivative 0)
//   h_i d_i-1 + 2 (h_i-1 + h_i) d_i + h_i-1 d_i+1
//       = 3 (h_i (v_i - v_i-1) / h_i-1 + h_i-1 (v_i+1 - v_i) / h_i)      (it is continuous)
// and at the last knot as at the first. Shape: knots x knots.
Eigen::MatrixXd SlopesOfValues(const std::vector<double>& x) {
  const auto n = static_cast<Eigen::Index>(x.size());
  Eigen::MatrixXd left = Eigen::MatrixXd::Zero(n, n), right = Eigen::MatrixXd::Zero(n, n);
  const auto h = [&](Eigen::Index i) {
    return x[static_cast<std::size_t>(i + 1)] - x[static_cast<std::size_t>(i)];
  };
  for (const bool first : {true, false}) {
    const Eigen::Index end = first ? 0 : n - 1, next = first ? 1 : n - 2, low = first ? 0 : n - 2;
    left(end, end) = 2.0;
    left(end, next) = 1.0;
    right(end, low) = -3.0 / h(low);
    right(end, low + 1) = 3.0 / h(low);
  }
  for (Eigen::Index i = 1; i + 1 < n; ++i) {
    const double before = h(i - 1), after = h(i);
    left(i, i - 1) = after;
    left(i, i) = 2.0 * (before + after);
    left(i, i + 1) = before;
    right(i, i - 1) = -3.0 * after / before;
    right(i, i) = 3.0 * (after / before - before / after);
    right(i, i + 1) = 3.0 * before / after;
  }
  return left.partialPivLu().solve(right);
}

}  // namespace

EmpiricalCurve::EmpiricalCurve(std::vector<double> knots) : knots_(std::move(knots)) {
  Check(knots_);
  slopes_.assign(knots_.size() * knots_.size(), 0.0);
  if (knots_.size() < 2) return;
  const auto n = static_cast<Eigen::Index>(knots_.size());
  Eigen::Map<Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>>(
      slopes_.data(), n, n) = SlopesOfValues(knots_);
}

EmpiricalCurve::Place EmpiricalCurve::Find(double x) const {
  Place place;
  if (x <= knots_.front() || knots_.size() < 2) {
    place.slope_low = x - knots_.front();
    return place;
  }
  if (x >= knots_.back()) {
    place.i = knots_.size() - 1;
    place.slope_low = x - knots_.back();
    return place;
  }
  // The last interval also takes a NaN, which the polynomials hand on.
  const auto after = std::upper_bound(knots_.begin(), knots_.end() - 1, x);
  place.i = static_cast<std::size_t>(after - knots_.begin()) - 1;
  const double h = knots_[place.i + 1] - knots_[place.i];
  const double u = (x - knots_[place.i]) / h, v = 1.0 - u;
  place.at_low = v * v * (1.0 + 2.0 * u);
  place.at_high = u * u * (1.0 + 2.0 * v);
  place.slope_low = h * u * v * v;
  place.slope_high = -h * u * u * v;
  return place;
}

void EmpiricalCurve::Weights(double x, double* weights) const {
  const Place place = Find(x);
  for (std::size_t j = 0; j < knots_.size(); ++j) {
    weights[j] = place.slope_low * Slope(place.i, j);
    if (place.i + 1 < knots_.size()) weights[j] += place.slope_high * Slope(place.i + 1, j);
  }
  weights[place.i] += place.at_low;
  if (place.i + 1 < knots_.size()) weights[place.i + 1] += place.at_high;
}

double EmpiricalCurve::Value(double x, std::span<const double> values) const {
  const Place place = Find(x);
  const bool has_next = place.i + 1 < knots_.size();
  double value = place.at_low * values[place.i];
  if (has_next) value += place.at_high * values[place.i + 1];
  for (std::size_t j = 0; j < knots_.size(); ++j) {
    value += place.slope_low * Slope(place.i, j) * values[j];
    if (has_next) value += place.slope_high * Slope(place.i + 1, j) * values[j];
  }
  return value;
}

}  // namespace gyrobench::calibration
