// What the uncertainty of the reference itself does to what is measured against it.
#pragma once

#include <Eigen/Core>
#include <array>

#include "base/geometry.h"
#include "base/measurement.h"

namespace gyrobench::calibration {

// The reference says w_ref where the sensor turns by w = (I + E) w_ref. Its errors E are small,
// independent of the readings' noise, and the same in every reading, so that no average takes them
// off. Standard uncertainties of the elements of E, as the reference's certificate bounds them
// (GUM, JCGM 100:2008, 4.3.7: a bound that is all one knows is a uniform distribution):
//   common    I times this: the relative uncertainty of a turned angle. One instrument and one
//             certificate: the error is the same about all axes
//   own       diagonal, each axis for itself: eccentricity a, an error a sin(phi + p) with any p
//             and an amplitude of up to a, over turns of phi_range in all:
//             a / sqrt(3) / sqrt(2) |2 sin(min(phi_range, 180 deg) / 2)| / phi_range;
//             and alignment theta, a turn seen as cos(theta) of itself: rms of theta^2 / 2 for
//             theta uniform up to its bound, theta_max^2 / (2 sqrt(5))
//   across    off the diagonal: the same tilt in an unknown direction, theta_max / sqrt(6)
// A contribution that is not said counts as none; where nothing is said at all, `said` is false.
struct ReferenceError {
  bool said = false;
  double common = 0.0;
  Vector3 own = {};
  double across = 0.0;

  // Relative standard uncertainty of the scale factor of one axis.
  double OfScale(std::size_t axis) const;
};

// What is to be said where nothing is said of the reference's own error.
inline constexpr const char* kRelativeToReference =
    "nothing is said of the reference's own error: the errors of what was measured against it are "
    "relative to the reference; give its relative standard uncertainty in [reference] of the stand "
    "file, or above the header of a table as \"# ref_scale_uncertainty = 0.0001\"";

// `range_deg`: by how much the sensor turned about each of its axes. NaN or 0: not at all.
ReferenceError MakeReferenceError(const ReferenceUncertainty& uncertainty,
                                  const Vector3& range_deg);

// Covariance that E brings into a matrix M that is estimated against the reference, of its elements
// row by row: M_est = M (I + E), dM_ij = sum_k M_ik E_kj.
Eigen::Matrix<double, 9, 9> ReferenceCovariance(const Eigen::Matrix3d& m,
                                                const ReferenceError& error);
// The same of one row of M.
Eigen::Matrix3d ReferenceCovariance(const Eigen::Vector3d& row, const ReferenceError& error);

}  // namespace gyrobench::calibration
