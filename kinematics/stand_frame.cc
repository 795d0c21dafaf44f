#include "kinematics/stand_frame.h"

#include "kinematics/rotations.h"

namespace gyrobench::kinematics {
namespace {

Matrix3 ToArrays(const Eigen::Matrix3d& m) {
  Matrix3 out = {};
  for (Eigen::Index row = 0; row < 3; ++row) {
    for (Eigen::Index column = 0; column < 3; ++column) {
      out[static_cast<std::size_t>(row)][static_cast<std::size_t>(column)] = m(row, column);
    }
  }
  return out;
}

}  // namespace

Matrix3 StandOrientation(const StandGeometry& geometry, const Vector3& angles_deg) {
  const FixedRotations fixed(geometry);
  return ToArrays(AboutZ(angles_deg[0]) * fixed.outer_middle * AboutX(angles_deg[1]) *
                  fixed.middle_inner * AboutZ(angles_deg[2]) * fixed.mount);
}

Matrix3 StandRates(const StandGeometry& geometry, const Vector3& angles_deg) {
  const FixedRotations fixed(geometry);
  // From the frames of the inner axis, the middle axis and the outer axis into S.
  const Eigen::Matrix3d inner = (AboutZ(angles_deg[2]) * fixed.mount).transpose();
  const Eigen::Matrix3d middle = inner * fixed.middle_inner.transpose();
  const Eigen::Matrix3d outer = middle * (fixed.outer_middle * AboutX(angles_deg[1])).transpose();
  Eigen::Matrix3d rates;
  rates << outer.col(2), middle.col(0), inner.col(2);
  return ToArrays(rates);
}

}  // namespace gyrobench::kinematics
