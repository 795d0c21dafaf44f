// Three gyro channels as one sensor, and its accelerometer: what a trace says of the vector model
//
//   w = A (xi - s0 (b(T) + effects)),   A = M^-1 diag(1 / s0)        [deg/s]
//   xi / s0 = M w + b(T) + effects + noise
//
// w in the frame N that the reference gives rates in (MeasurementInfo::geometry is in them). Plain
// values; NaN is what is not known. docs/calibration.md has the conventions.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "base/geometry.h"
#include "base/measurement.h"

namespace gyrobench::calibration {

inline constexpr Vector3 kUnknown3 = {kMissing, kMissing, kMissing};
inline constexpr Matrix3 kUnknown33 = {kUnknown3, kUnknown3, kUnknown3};

// M and A with their errors. Covariances: 9 x 9, row by row, of the elements xx xy xz yx ... zz.
struct VectorMatrix {
  Matrix3 m = kUnknown33, m_std_error = kUnknown33;  // deg/s per deg/s
  Matrix3 a = kUnknown33, a_std_error = kUnknown33;  // deg/s per unit of xi
  std::vector<double> m_covariance, a_covariance;
  // Without the reference's own uncertainty, which the errors and covariances above contain.
  Matrix3 m_statistical_std_error = kUnknown33, a_statistical_std_error = kUnknown33;
};

// M = diag(scale) P R_mount^T: row i of M is scale_i times the unit vector n_i of sensitive axis i.
//   P       = sqrt(G), symmetric, G_ij = n_i . n_j = sin(non-orthogonality of i and j): 90 deg less
//             the angle between the two axes
//   R_mount rotates vectors of the sensor's own frame into N, Rz(mount z) Ry(mount y) Rx(mount x),
//             as mount_x_deg ... of the stand file. The own frame is the one nearest to the three
//             axes (least squares of their directions), none of them preferred.
// Scale and non-orthogonality do not depend on how the sensor is mounted.
struct AxisSplit {
  Vector3 scale = kUnknown3, scale_std_error = kUnknown3;
  Vector3 non_orthogonality_deg = kUnknown3;  // of the pairs yz, zx, xy
  Vector3 non_orthogonality_std_error_deg = kUnknown3;
  Matrix3 r_mount = kUnknown33;
  Vector3 mount_deg = kUnknown3;  // about x, y, z; none has errors where y is +-90 deg
  Vector3 mount_std_error_deg = kUnknown3;
};

// The offset's change with gravity: row i, column j [deg/s/g], channel i by gravity along j.
struct GSensitivity {
  Matrix3 value = kUnknown33, std_error = kUnknown33;
  // Without what the Earth's rotation may be of it, where that was not taken off.
  Matrix3 statistical_std_error = kUnknown33;
  // The channel's model has bias.g_linear, and apply takes it off. Otherwise the row was estimated
  // next to the model, and its rows say how little there is.
  std::array<bool, 3> in_model = {};
  std::vector<std::string> because;  // why elements are not known
};

// An effect of bench or reference that several channels feel, by generalised least squares.
struct SharedParameter {
  std::string name, unit;
  std::string channels;  // "xy"
  double value = kMissing, std_error = kMissing;
  double p_value = kMissing;  // that channels which agree would differ so much
};

// The accelerometer's own word on itself: the size of what it feels at rest is 1 g in every pose,
// whatever the reference says.
struct GravityCheck {
  double rms_before_g = kMissing, rms_after_g = kMissing;  // of size less 1, over the poses
  Vector3 scale = kUnknown3, scale_std_error = kUnknown3;
  Vector3 offset_g = kUnknown3, offset_std_error_g = kUnknown3;
  Vector3 non_orthogonality_deg = kUnknown3;  // yz, zx, xy
  Vector3 non_orthogonality_std_error_deg = kUnknown3;
  // Largest difference to the fit by the reference in standard errors; NaN where there is none.
  double largest_difference = kMissing;
};

// accel = M g + offset at rest [g], g the reference's gravity in N: +1 on the axis that points up.
struct AccelerometerCalibration {
  std::int64_t poses = 0;  // rests
  Matrix3 m = kUnknown33, m_std_error = kUnknown33;
  Vector3 offset_g = kUnknown3, offset_std_error_g = kUnknown3;
  // Of a pose's mean beyond the noise within it: reference, temperature, table [g].
  double pose_scatter_g = kMissing;
  std::optional<AxisSplit> split;
  std::optional<GravityCheck> check;
  std::vector<std::string> because;  // what these poses do not show
};

struct VectorCalibration {
  std::vector<std::string> missing;    // why there is no matrix
  std::string unit;                    // of xi
  std::optional<VectorMatrix> matrix;  // all nine elements are known
  std::optional<AxisSplit> split;
  std::optional<GSensitivity> g_sensitivity;
  std::vector<SharedParameter> shared;
  // Share by which M's standard errors would fall at most, were the shared parameters held equal.
  double shared_gain = kMissing;
  std::optional<AccelerometerCalibration> accelerometer;
  std::vector<std::string> remarks;
};

}  // namespace gyrobench::calibration
