#include "calibration/sensor/matrix_inverse.h"

#include <Eigen/LU>

namespace gyrobench::calibration {

MatrixWithCovariance InverseOver(const MatrixWithCovariance& m, const Eigen::Vector3d& s0) {
  const Eigen::Matrix3d b = m.value.inverse();
  MatrixWithCovariance out;
  out.value = b * s0.cwiseInverse().asDiagonal();
  Matrix9 slope;
  for (Eigen::Index i = 0; i < 3; ++i)
    for (Eigen::Index j = 0; j < 3; ++j)
      for (Eigen::Index k = 0; k < 3; ++k)
        for (Eigen::Index l = 0; l < 3; ++l)
          slope(3 * i + j, 3 * k + l) = -b(i, k) * out.value(l, j);
  out.covariance = slope * m.covariance * slope.transpose();
  return out;
}

}  // namespace gyrobench::calibration
