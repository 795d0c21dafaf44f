#include "calibration/sensor/accelerometer.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <Eigen/LU>
#include <algorithm>
#include <array>
#include <cmath>
#include <string>
#include <utility>
#include <vector>

#include "calibration/sensor/least_squares.h"
#include "calibration/sensor/sensor_matrix.h"

namespace gyrobench::calibration {
namespace {

// Of an axis: gravity's components, and 1 for the offset.
using Row4 = Eigen::Vector4d;
Row4 RowOf(const Pose& pose) { return (Row4() << pose.gravity_g, 1.0).finished(); }

struct ReferenceFit {
  std::array<SeenSolution, 3> axes;
  double chi_square = 0.0, freedom = 0.0;
};

ReferenceFit FitAt(std::span<const Pose> poses, double scatter_g2) {
  Eigen::Matrix4d gram = Eigen::Matrix4d::Zero();
  Eigen::Matrix<double, 4, 3> right = Eigen::Matrix<double, 4, 3>::Zero();
  double weights = 0.0;
  for (const Pose& pose : poses) {
    const double weight = 1.0 / (pose.variance_g2 + scatter_g2);
    const Row4 row = RowOf(pose);
    gram += weight * row * row.transpose();
    right += weight * row * pose.accel_g.transpose();
    weights += weight;
  }
  ReferenceFit fit;
  for (std::size_t c = 0; c < 3; ++c) {
    fit.axes[c] =
        SolveSeen(gram, right.col(static_cast<Eigen::Index>(c)), kLeastGravitySquare_g2 * weights);
    for (const Pose& pose : poses) {
      const double left =
          pose.accel_g[static_cast<Eigen::Index>(c)] - fit.axes[c].values.dot(RowOf(pose));
      fit.chi_square += left * left / (pose.variance_g2 + scatter_g2);
    }
    const auto& seen = fit.axes[c].seen;
    fit.freedom += static_cast<double>(poses.size()) -
                   static_cast<double>(std::count(seen.begin(), seen.end(), true));
  }
  return fit;
}

// The scatter from pose to pose that makes the residual as large as it is; 0 where noise does.
double FindScatter(std::span<const Pose> poses) {
  const auto too_small = [&](double scatter_g2) {
    const ReferenceFit fit = FitAt(poses, scatter_g2);
    return fit.freedom > 0.0 && fit.chi_square > fit.freedom;
  };
  if (!too_small(0.0)) return 0.0;
  double low = 0.0, high = 1.0;
  for (int i = 0; i < 50; ++i) {
    const double middle = 0.5 * (low + high);
    (too_small(middle) ? low : high) = middle;
  }
  return high;
}

// "M_xx, M_xy and the offset of x"
std::string Unseen(const ReferenceFit& fit) {
  std::vector<std::string> names;
  for (std::size_t j = 0; j < 3; ++j)
    if (!fit.axes[0].seen[j]) names.push_back(fmt::format("column {} of its matrix", "xyz"[j]));
  if (!fit.axes[0].seen[3]) names.emplace_back("its offset");
  return fmt::format("{}", fmt::join(names, ", "));
}

void Take(const ReferenceFit& fit, AccelerometerCalibration* out) {
  MatrixWithCovariance m;
  bool whole = true;
  for (std::size_t c = 0; c < 3; ++c) {
    const SeenSolution& axis = fit.axes[c];
    const auto row = static_cast<Eigen::Index>(c);
    m.value.row(row) = axis.values.head<3>();
    m.covariance.block<3, 3>(3 * row, 3 * row) = axis.covariance.topLeftCorner<3, 3>();
    for (std::size_t j = 0; j < 4; ++j) {
      const auto k = static_cast<Eigen::Index>(j);
      whole = whole && axis.seen[j];
      if (!axis.seen[j]) continue;
      (j < 3 ? out->m[c][j] : out->offset_g[c]) = axis.values[k];
      (j < 3 ? out->m_std_error[c][j] : out->offset_std_error_g[c]) =
          std::sqrt(axis.covariance(k, k));
    }
  }
  if (whole) {
    out->split = SplitAxes(m);
    if (!out->split)
      out->because.emplace_back("its axes are left-handed or do not span space: no scale factors");
  } else {
    out->because.push_back(fmt::format(
        "the poses do not show {}: hold each axis up and down, and one more pose", Unseen(fit)));
  }
}

// Size of what the accelerometer feels, once it is corrected.
double CorrectedRms(std::span<const Pose> poses, const AccelerometerCalibration& by) {
  Eigen::Matrix3d m;
  for (std::size_t i = 0; i < 3; ++i)
    for (std::size_t j = 0; j < 3; ++j)
      m(static_cast<Eigen::Index>(i), static_cast<Eigen::Index>(j)) = by.m[i][j];
  const Eigen::Vector3d offset(by.offset_g[0], by.offset_g[1], by.offset_g[2]);
  double sum = 0.0;
  for (const Pose& pose : poses)
    sum += std::pow((m.inverse() * (pose.accel_g - offset)).norm() - 1.0, 2);
  return std::sqrt(sum / static_cast<double>(poses.size()));
}

double LargestDifference(const AccelerometerCalibration& by, const GravityCheck& check) {
  double largest = kMissing;
  const auto compare = [&](const Vector3& one, const Vector3& other, const Vector3& error) {
    for (std::size_t k = 0; k < 3; ++k)
      largest = std::fmax(largest, std::fabs(one[k] - other[k]) / error[k]);
  };
  compare(by.offset_g, check.offset_g, check.offset_std_error_g);
  if (!by.split) return largest;
  compare(by.split->scale, check.scale, check.scale_std_error);
  compare(by.split->non_orthogonality_deg, check.non_orthogonality_deg,
          check.non_orthogonality_std_error_deg);
  return largest;
}

}  // namespace

std::optional<AccelerometerCalibration> CalibrateAccelerometer(std::span<const Pose> poses) {
  if (poses.empty()) return std::nullopt;
  AccelerometerCalibration out;
  out.poses = static_cast<std::int64_t>(poses.size());
  std::vector<Pose> told;
  for (const Pose& pose : poses)
    if (pose.gravity_g.allFinite()) told.push_back(pose);
  double scatter_g2 = 0.0;
  if (told.empty()) {
    out.because.emplace_back(
        "the reference gives no orientation: nothing but the size of gravity tells of the "
        "accelerometer");
  } else {
    scatter_g2 = FindScatter(told);
    const ReferenceFit fit = FitAt(told, scatter_g2);
    if (fit.freedom > 0.0) out.pose_scatter_g = std::sqrt(scatter_g2);
    Take(fit, &out);
  }
  out.check = CheckGravity(poses, scatter_g2);
  if (out.split) out.check->rms_after_g = CorrectedRms(told, out);
  out.check->largest_difference = LargestDifference(out, *out.check);
  return out;
}

AccelCorrection::AccelCorrection(const std::optional<VectorCalibration>& vector) {
  constexpr double kLeastVolume = 1e-3;
  if (!vector || !vector->accelerometer) return;
  const AccelerometerCalibration& accelerometer = *vector->accelerometer;
  Eigen::Matrix3d m;
  Eigen::Vector3d offset;
  for (std::size_t i = 0; i < 3; ++i) {
    const auto row = static_cast<Eigen::Index>(i);
    for (std::size_t j = 0; j < 3; ++j)
      m(row, static_cast<Eigen::Index>(j)) = accelerometer.m[i][j];
    offset[row] = accelerometer.offset_g[i];
  }
  if (!offset.allFinite() || !(std::fabs(m.determinant()) > kLeastVolume)) return;
  calibrated_ = true;
  inverse_ = m.inverse();
  offset_ = offset;
}

std::array<double, 3> AccelCorrection::Apply(const std::array<double, 3>& accel_g) const {
  if (!calibrated_) return accel_g;
  const Eigen::Vector3d corrected =
      inverse_ * (Eigen::Vector3d(accel_g[0], accel_g[1], accel_g[2]) - offset_);
  return {corrected[0], corrected[1], corrected[2]};
}

}  // namespace gyrobench::calibration
