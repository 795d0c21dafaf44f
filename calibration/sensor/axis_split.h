// A sensor's matrix as scale factors, non-orthogonality and mounting rotation.
#pragma once

#include <Eigen/Core>
#include <optional>

#include "calibration/sensor/matrix_inverse.h"
#include "calibration/sensor/vector_calibration.h"

namespace gyrobench::calibration {

// AxisSplit by the polar decomposition of the sensitive axes' directions, errors by its derivative.
// nullopt where the axes do not span space, or are left-handed: then one axis has its sign
// reversed, and no rotation makes up for it.
std::optional<AxisSplit> SplitAxes(const MatrixWithCovariance& m);

// The matrix that a split is of: diag(scale) sqrt(G) R_mount^T.
Eigen::Matrix3d Recompose(const AxisSplit& split);

}  // namespace gyrobench::calibration
