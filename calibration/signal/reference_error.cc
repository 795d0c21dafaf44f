#include "calibration/signal/reference_error.h"

#include <algorithm>
#include <cmath>

#include "base/geometry.h"

namespace gyrobench::calibration {
namespace {

// Of the slope of the angle over `range_deg`, per unit of an error's amplitude in deg.
double EccentricityShare(double range_deg) {
  if (!(range_deg > 0.0)) return 0.0;
  const double chord = 2.0 * std::sin(0.5 * std::min(range_deg, 180.0) * kRadPerDeg);
  return chord / (std::sqrt(6.0) * range_deg);
}

// `row` by E, as many columns as E has independent parts.
Eigen::Matrix<double, 3, 10> RowByParts(const Eigen::Vector3d& row, const ReferenceError& error) {
  Eigen::Matrix<double, 3, 10> parts = Eigen::Matrix<double, 3, 10>::Zero();
  parts.col(0) = error.common * row;
  Eigen::Index part = 1;
  for (Eigen::Index k = 0; k < 3; ++k) {
    for (Eigen::Index j = 0; j < 3; ++j, ++part) {
      const double u = k == j ? error.own[static_cast<std::size_t>(j)] : error.across;
      parts(j, part) = u * row(k);
    }
  }
  return parts;
}

}  // namespace

double ReferenceError::OfScale(std::size_t axis) const { return std::hypot(common, own[axis]); }

ReferenceError MakeReferenceError(const ReferenceUncertainty& uncertainty,
                                  const Vector3& range_deg) {
  ReferenceError error;
  error.said = uncertainty.said();
  error.common = uncertainty.scale.value_or(0.0);
  const double tilt = uncertainty.alignment_deg.value_or(0.0) * kRadPerDeg;
  error.across = tilt / std::sqrt(6.0);
  for (std::size_t c = 0; c < 3; ++c) {
    error.own[c] =
        std::hypot(uncertainty.eccentricity_deg.value_or(0.0) * EccentricityShare(range_deg[c]),
                   tilt * tilt / (2.0 * std::sqrt(5.0)));
  }
  return error;
}

Eigen::Matrix<double, 9, 9> ReferenceCovariance(const Eigen::Matrix3d& m,
                                                const ReferenceError& error) {
  Eigen::Matrix<double, 9, 10> parts;
  for (Eigen::Index i = 0; i < 3; ++i)
    parts.block<3, 10>(3 * i, 0) = RowByParts(m.row(i).transpose(), error);
  return parts * parts.transpose();
}

Eigen::Matrix3d ReferenceCovariance(const Eigen::Vector3d& row, const ReferenceError& error) {
  const Eigen::Matrix<double, 3, 10> parts = RowByParts(row, error);
  return parts * parts.transpose();
}

}  // namespace gyrobench::calibration
