#include <Eigen/LU>
#include <algorithm>
#include <array>
#include <cmath>

#include "base/geometry.h"
#include "calibration/sensor/accelerometer.h"
#include "calibration/sensor/least_squares.h"

namespace gyrobench::calibration {
namespace {

using Eigen::Vector3d;
using Vector9 = Eigen::Matrix<double, 9, 1>;

constexpr int kSteps = 20;

// scale, offset [g], non-orthogonality [rad]
struct SizeOf {
  double size = 0.0;
  Vector9 slope;
};

SizeOf SizeAt(const Vector3d& accel_g, const Vector9& p) {
  Eigen::Matrix3d g = Eigen::Matrix3d::Identity();
  for (std::size_t k = 0; k < 3; ++k) {
    const auto [i, j] = kAxisPairs[k];
    g(i, j) = g(j, i) = std::sin(p[6 + static_cast<Eigen::Index>(k)]);
  }
  const Vector3d u = (accel_g - p.segment<3>(3)).cwiseQuotient(p.head<3>());
  const Vector3d y = g.inverse() * u;
  SizeOf out;
  out.size = std::sqrt(u.dot(y));
  const Vector3d by_u = y / out.size;
  out.slope.head<3>() = -by_u.cwiseProduct(u).cwiseQuotient(p.head<3>());
  out.slope.segment<3>(3) = -by_u.cwiseQuotient(p.head<3>());
  for (std::size_t k = 0; k < 3; ++k) {
    const auto [i, j] = kAxisPairs[k];
    const auto at = 6 + static_cast<Eigen::Index>(k);
    out.slope[at] = -y[i] * y[j] * std::cos(p[at]) / out.size;
  }
  return out;
}

struct Fit {
  Vector9 values;
  SeenSolution last;
  double chi_square = 0.0;
};

Fit FitSize(std::span<const Pose> poses, double scatter_g2) {
  Fit fit;
  fit.values << Vector3d::Ones(), Eigen::Matrix<double, 6, 1>::Zero();
  for (int step = 0; step < kSteps; ++step) {
    Eigen::Matrix<double, 9, 9> gram = Eigen::Matrix<double, 9, 9>::Zero();
    Vector9 right = Vector9::Zero();
    double weights = 0.0;
    fit.chi_square = 0.0;
    for (const Pose& pose : poses) {
      const double weight = 1.0 / (pose.variance_g2 + scatter_g2);
      const SizeOf at = SizeAt(pose.accel_g, fit.values);
      gram += weight * at.slope * at.slope.transpose();
      right += weight * (1.0 - at.size) * at.slope;
      weights += weight;
      fit.chi_square += weight * std::pow(1.0 - at.size, 2);
    }
    fit.last = SolveSeen(gram, right, kLeastGravitySquare_g2 * weights);
    fit.values += fit.last.values;
  }
  return fit;
}

void Fill(const Fit& fit, double grow, GravityCheck* out) {
  const auto put = [&](std::size_t j, double unit, double& value, double& error) {
    const auto k = static_cast<Eigen::Index>(j);
    if (!fit.last.seen[j] || !fit.values.allFinite()) return;
    value = fit.values[k] * unit;
    error = std::sqrt(fit.last.covariance(k, k)) * grow * unit;
  };
  for (std::size_t c = 0; c < 3; ++c) {
    put(c, 1.0, out->scale[c], out->scale_std_error[c]);
    put(3 + c, 1.0, out->offset_g[c], out->offset_std_error_g[c]);
    put(6 + c, kDegPerRad, out->non_orthogonality_deg[c], out->non_orthogonality_std_error_deg[c]);
  }
}

}  // namespace

GravityCheck CheckGravity(std::span<const Pose> poses, double scatter_g2) {
  GravityCheck out;
  double sum = 0.0;
  for (const Pose& pose : poses) sum += std::pow(pose.accel_g.norm() - 1.0, 2);
  out.rms_before_g = std::sqrt(sum / static_cast<double>(poses.size()));
  const Fit fit = FitSize(poses, scatter_g2);
  const auto seen = std::count(fit.last.seen.begin(), fit.last.seen.end(), true);
  const double freedom = static_cast<double>(poses.size()) - static_cast<double>(seen);
  const double grow = freedom > 0.0 ? std::sqrt(std::max(1.0, fit.chi_square / freedom)) : 1.0;
  Fill(fit, grow, &out);
  return out;
}

}  // namespace gyrobench::calibration
