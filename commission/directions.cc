#include "commission/directions.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <numeric>

#include "kinematics/rotations.h"
#include "kinematics/stand_frame.h"

namespace gyrobench::commission {
namespace {

// Beyond the misfit of the best: the sensor's own axes, leans and worms make less of it.
constexpr double kNearlyAsGood_deg = 1.0;

using kinematics::ToEigen;

// R_mount, which rotates the sensor's vectors into the table's frame.
Eigen::Matrix3d Mount(const std::array<double, 3>& mount_deg) {
  return kinematics::FixedRotations({.mount_deg = mount_deg}).mount;
}

double AngleOf_deg(const Eigen::Matrix3d& rotation) {
  return std::fabs(Eigen::AngleAxisd(rotation).angle()) * kDegPerRad;
}

std::array<double, 3> MountAngles_deg(const Eigen::Matrix3d& rotation) {
  const Eigen::Vector3d angles = kinematics::MountAngles_rad(rotation) * kDegPerRad;
  return {angles[0], angles[1], angles[2]};
}

// The rotation that takes what is seen to what is expected (Kabsch 1976). Where all of it lies
// along one direction a turn about that cannot be seen: of the right angles from the one before,
// the one that fits and is nearest to it.
Eigen::Matrix3d BestMount(const std::vector<Eigen::Vector3d>& expected,
                          const std::vector<Eigen::Vector3d>& seen, const Eigen::Matrix3d& before) {
  constexpr double kOneDirection = 0.02;
  Eigen::Matrix3d sum = Eigen::Matrix3d::Zero();
  for (std::size_t i = 0; i < seen.size(); ++i) sum += expected[i] * seen[i].transpose();
  const Eigen::JacobiSVD<Eigen::Matrix3d> svd(sum, Eigen::ComputeFullU | Eigen::ComputeFullV);
  if (svd.singularValues()(1) > kOneDirection * svd.singularValues()(0)) {
    Eigen::Vector3d proper = Eigen::Vector3d::Ones();
    proper(2) = (svd.matrixU() * svd.matrixV().transpose()).determinant() < 0.0 ? -1.0 : 1.0;
    return svd.matrixU() * proper.asDiagonal() * svd.matrixV().transpose();
  }
  Eigen::Matrix3d best = before;
  double most = (before.transpose() * sum).trace();
  for (const double x : {0.0, 90.0, 180.0, 270.0}) {
    for (const double y : {0.0, 90.0, 270.0}) {
      const Eigen::Matrix3d mount = Mount({x, y, 0.0}) * before;
      const double fit = (mount.transpose() * sum).trace();
      if (fit <= most + 1e-6 * static_cast<double>(seen.size())) continue;
      most = fit;
      best = mount;
    }
  }
  return best;
}

class Fit {
 public:
  Fit(const StandGeometry& configured, const std::vector<std::size_t>& stand_axes, const Felt& felt,
      const std::vector<double>& scales)
      : configured_(configured), stand_axes_(stand_axes), felt_(felt), scales_(scales) {
    StandGeometry on_table = configured;
    on_table.mount_deg = {};
    frame_ = kinematics::StandFrame(on_table);
    const Matrix3 at_marks = frame_.Orientation({});
    frame_up_ = Eigen::Vector3d(at_marks[2][0], at_marks[2][1], at_marks[2][2]);
  }

  // With the mounting that fits best.
  Assignment Best(Assignment wired) const {
    const Eigen::Matrix3d before = Mount(configured_.mount_deg);
    std::vector<Eigen::Vector3d> expected, seen;
    for (const Move* move : felt_.moves) {
      expected.push_back(Expected(wired, *move));
      seen.push_back(ToEigen(move->turned_deg).normalized());
    }
    if (Length(felt_.up) > 0.0) {
      expected.push_back(frame_up_);
      seen.push_back(ToEigen(felt_.up).normalized());
    }
    const Eigen::Matrix3d mount = BestMount(expected, seen, before);
    double square = 0.0;
    for (std::size_t i = 0; i < seen.size(); ++i) {
      const double cosine = expected[i].dot(mount * seen[i]);
      square += std::pow(std::acos(std::clamp(cosine, -1.0, 1.0)) * kDegPerRad, 2);
    }
    wired.misfit_deg =
        std::sqrt(square / static_cast<double>(std::max<std::size_t>(1, seen.size())));
    wired.mounting_off_deg = AngleOf_deg(mount * before.transpose());
    wired.geometry = configured_;
    wired.geometry.mount_deg = MountAngles_deg(mount);
    return wired;
  }

 private:
  // In the inner table's frame.
  Eigen::Vector3d Expected(const Assignment& wired, const Move& move) const {
    Vector3 angles_deg = {};
    for (std::size_t i = 0; i < wired.axis_of_drive.size(); ++i) {
      angles_deg[stand_axes_[wired.axis_of_drive[i]]] =
          wired.sense_of_drive[i] * scales_[i] * move.begin_deg[i];
    }
    const Matrix3 rates = frame_.Rates(angles_deg);
    const std::size_t axis = stand_axes_[wired.axis_of_drive[move.drive]];
    const double sense = wired.sense_of_drive[move.drive] * (move.commanded_deg < 0.0 ? -1.0 : 1.0);
    return sense * Eigen::Vector3d(rates[0][axis], rates[1][axis], rates[2][axis]);
  }

  const StandGeometry& configured_;
  const std::vector<std::size_t>& stand_axes_;
  const Felt& felt_;
  const std::vector<double>& scales_;
  kinematics::StandFrame frame_;
  Eigen::Vector3d frame_up_;  // with the axes at their marks, in the inner table's frame
};

}  // namespace

std::vector<Assignment> FittingAssignments(const StandGeometry& configured,
                                           const std::vector<std::size_t>& stand_axes,
                                           const Felt& felt, const std::vector<double>& scales) {
  const Fit fit(configured, stand_axes, felt, scales);
  const std::size_t n = stand_axes.size();
  std::vector<Assignment> all;
  Assignment wired;
  wired.axis_of_drive.resize(n);
  std::iota(wired.axis_of_drive.begin(), wired.axis_of_drive.end(), std::size_t{0});
  do {
    for (unsigned senses = 0; senses < (1U << n); ++senses) {
      wired.sense_of_drive.clear();
      for (std::size_t i = 0; i < n; ++i)
        wired.sense_of_drive.push_back((senses >> i & 1U) != 0 ? -1 : 1);
      all.push_back(fit.Best(wired));
    }
  } while (std::ranges::next_permutation(wired.axis_of_drive).found);
  const double best = std::ranges::min(all, {}, &Assignment::misfit_deg).misfit_deg;
  std::erase_if(all,
                [&](const Assignment& one) { return one.misfit_deg > best + kNearlyAsGood_deg; });
  return all;
}

}  // namespace gyrobench::commission
