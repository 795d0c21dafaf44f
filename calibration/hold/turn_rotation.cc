#include "calibration/hold/turn_rotation.h"

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <array>
#include <cmath>

namespace gyrobench::calibration {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

// -A's columns seen from the beginning, times what multiplies them, for all i and j.
Matrix39 ByElements(const std::array<Matrix3d, 3>& integrals, const Matrix3d& a) {
  Matrix39 out;
  for (int j = 0; j < 3; ++j) {
    const Matrix3d columns = -integrals[static_cast<std::size_t>(j)] * a;
    for (int i = 0; i < 3; ++i) out.col(3 * i + j) = columns.col(i);
  }
  return out;
}

// What is integrated over the turn along with the rotation.
struct Integrals {
  std::array<Matrix3d, 3> by_rate, by_force, bent;
  Matrix3d early = Matrix3d::Zero(), late = Matrix3d::Zero();
  Integrals() {
    for (std::size_t j = 0; j < 3; ++j) by_rate[j] = by_force[j] = bent[j] = Matrix3d::Zero();
  }
};

struct EpochRotation {
  Vector3d vector, force_g;
};

EpochRotation RotationVector(const Epoch& epoch, const GyroParameters& gyro, const Matrix3d& a,
                             const Matrix3d& cofactor, const Vector3d& beta) {
  EpochRotation out;
  out.force_g = Vector3d::Zero();
  if (epoch.accel_g.allFinite())
    out.force_g = gyro.accel_inverse * (epoch.accel_g - gyro.accel_offset_g);
  // The offset in units of xi.
  Epoch freed = epoch;
  Detrend((beta + gyro.g_sensitivity * out.force_g) / gyro.unit, &freed);
  out.vector = gyro.unit * (a * freed.angle) + gyro.unit * gyro.unit * (cofactor * freed.coning);
  return out;
}

void AddBent(const Matrix3d& middle, const Vector3d& y, double h, Integrals* sums) {
  for (int i = 0; i < 3; ++i) {
    sums->bent[0].col(i) += h * std::fabs(y[i]) * middle.col(i);
    sums->bent[1].col(i) += h * y[i] * y[i] * middle.col(i);
    sums->bent[2].col(i) += h * y[i] * std::fabs(y[i]) * middle.col(i);
  }
}

}  // namespace

Matrix3d RotationOf(const Vector3d& v) {
  const double angle = v.norm();
  if (angle < 1e-12) {
    Matrix3d small = Matrix3d::Identity();
    small(0, 1) = -v.z(), small(0, 2) = v.y(), small(1, 0) = v.z();
    small(1, 2) = -v.x(), small(2, 0) = -v.y(), small(2, 1) = v.x();
    return small;
  }
  return Eigen::AngleAxisd(angle, v / angle).toRotationMatrix();
}

TurnRotation IntegrateTurn(std::span<const Epoch> epochs, const GyroParameters& gyro,
                           const Vector3d& beta_begin, const Vector3d& beta_end) {
  TurnRotation out;
  if (epochs.empty()) return out;
  const Matrix3d a = gyro.m.inverse();
  const Matrix3d cofactor = a.determinant() * gyro.m.transpose();
  const double begin_s = epochs.front().begin_s, length_s = epochs.back().end_s - begin_s;
  Integrals sums;
  for (const Epoch& epoch : epochs) {
    const double h = epoch.duration_s();
    const double late = (0.5 * (epoch.begin_s + epoch.end_s) - begin_s) / length_s;
    const Vector3d beta = beta_begin + late * (beta_end - beta_begin);
    const EpochRotation step = RotationVector(epoch, gyro, a, cofactor, beta);
    const Matrix3d half = RotationOf(0.5 * step.vector);
    const Matrix3d middle = out.r * half;
    for (int j = 0; j < 3; ++j) {
      const auto at = static_cast<std::size_t>(j);
      sums.by_rate[at] += step.vector[j] * middle;
      sums.by_force[at] += h * step.force_g[j] * middle;
    }
    sums.early += h * (1.0 - late) * middle;
    sums.late += h * late * middle;
    AddBent(middle * a, gyro.m * step.vector / h, h, &sums);
    out.r = middle * half;
  }
  out.by_m = ByElements(sums.by_rate, a);
  out.by_g_sensitivity = ByElements(sums.by_force, a);
  out.by_beta_begin = -sums.early * a;
  out.by_beta_end = -sums.late * a;
  for (int k = 0; k < 3; ++k)
    out.by_bent_scale.middleCols<3>(3 * k) = -sums.bent[static_cast<std::size_t>(k)];
  return out;
}

}  // namespace gyrobench::calibration
