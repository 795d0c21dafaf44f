#include "kinematics/pose_candidates.h"

#include <algorithm>
#include <cmath>

namespace gyrobench::kinematics {
namespace {

constexpr std::size_t kOuter = 0, kMiddle = 1, kInner = 2;
// A direction this near to the axis that is to turn it has no azimuth about it.
constexpr double kNoAzimuth = 1e-9;

// The angle [deg] that turns the plane vector (ax, ay) onto the direction of (bx, by); `otherwise`
// where one of them is too short to have a direction.
double TurnOnto(double ax, double ay, double bx, double by, double otherwise) {
  if (std::hypot(ax, ay) < kNoAzimuth || std::hypot(bx, by) < kNoAzimuth) return otherwise;
  return (std::atan2(by, bx) - std::atan2(ay, ax)) / kRadPerDeg;
}

double ArcCosine_deg(double cosine) {
  return std::acos(std::clamp(cosine, -1.0, 1.0)) / kRadPerDeg;
}

}  // namespace

std::vector<double> PoseCandidates::InnerForUp(const Eigen::Vector3d& v) const {
  if (!movable_[kInner]) return {rest_deg_[kInner]};
  const Eigen::Vector3d w = fixed_.outer_middle.transpose() * Eigen::Vector3d::UnitZ();
  if (!movable_[kMiddle]) {
    const Eigen::Vector3d g =
        fixed_.middle_inner.transpose() * AboutX(rest_deg_[kMiddle]).transpose() * w;
    return {TurnOnto(v.x(), v.y(), g.x(), g.y(), rest_deg_[kInner])};
  }
  // c (v_x cos i - v_y sin i) + s v_z = w_x, with E2 = Ry: c cos(i + azimuth) |v_xy| = w_x - s v_z.
  const double c = fixed_.middle_inner(0, 0), s = fixed_.middle_inner(0, 2);
  const double length = c * std::hypot(v.x(), v.y());
  if (length < kNoAzimuth) return {rest_deg_[kInner]};
  const double azimuth_deg = std::atan2(v.y(), v.x()) / kRadPerDeg;
  const double half_deg = ArcCosine_deg((w.x() - s * v.z()) / length);
  return {half_deg - azimuth_deg, -half_deg - azimuth_deg, rest_deg_[kInner]};
}

Vector3 PoseCandidates::MiddleForUp(Vector3 angles_deg, const Eigen::Vector3d& up) const {
  if (!movable_[kMiddle]) return angles_deg;
  const Eigen::Vector3d w = fixed_.outer_middle.transpose() * Eigen::Vector3d::UnitZ();
  const Eigen::Vector3d q = fixed_.middle_inner * AboutZ(angles_deg[kInner]) * fixed_.mount * up;
  angles_deg[kMiddle] = TurnOnto(q.y(), q.z(), w.y(), w.z(), rest_deg_[kMiddle]);
  return angles_deg;
}

std::vector<Vector3> PoseCandidates::OuterAlong(const Eigen::Vector3d& s) const {
  std::vector<Vector3> candidates;
  for (const double inner_deg : InnerForUp(fixed_.mount * s)) {
    candidates.push_back(MiddleForUp({rest_deg_[kOuter], rest_deg_[kMiddle], inner_deg}, s));
  }
  return candidates;
}

Vector3 PoseCandidates::MiddleAlong(const Eigen::Vector3d& s) const {
  Vector3 angles_deg = rest_deg_;
  if (!movable_[kInner]) return angles_deg;
  const Eigen::Vector3d g = fixed_.middle_inner.transpose() * Eigen::Vector3d::UnitX();
  const Eigen::Vector3d v = fixed_.mount * s;
  angles_deg[kInner] = TurnOnto(v.x(), v.y(), g.x(), g.y(), rest_deg_[kInner]);
  return angles_deg;
}

// d = Rz(outer) K Rz(inner), K = E1 Rx(middle) E2, with outer given.
Vector3 PoseCandidates::WithOuter(const Eigen::Matrix3d& d, double middle_deg,
                                  double outer_deg) const {
  const Eigen::Matrix3d k = fixed_.outer_middle * AboutX(middle_deg) * fixed_.middle_inner;
  const Eigen::Matrix3d inner = (AboutZ(outer_deg) * k).transpose() * d;
  const double inner_deg =
      movable_[kInner] ? std::atan2(inner(1, 0), inner(0, 0)) / kRadPerDeg : rest_deg_[kInner];
  return {outer_deg, middle_deg, inner_deg};
}

Vector3 PoseCandidates::WithInner(const Eigen::Matrix3d& d, double middle_deg,
                                  double inner_deg) const {
  const Eigen::Matrix3d k = fixed_.outer_middle * AboutX(middle_deg) * fixed_.middle_inner;
  const Eigen::Matrix3d outer = d * (k * AboutZ(inner_deg)).transpose();
  const double outer_deg =
      movable_[kOuter] ? std::atan2(outer(1, 0), outer(0, 0)) / kRadPerDeg : rest_deg_[kOuter];
  return {outer_deg, middle_deg, inner_deg};
}

std::vector<Vector3> PoseCandidates::Holding(const Eigen::Matrix3d& orientation) const {
  const Eigen::Matrix3d d = orientation * fixed_.mount.transpose();
  // z^T E1 Rx(m) E2 z = c1 c2 cos m - s1 s2.
  const double c1 = fixed_.outer_middle(0, 0), s1 = fixed_.outer_middle(0, 2);
  const double c2 = fixed_.middle_inner(0, 0), s2 = fixed_.middle_inner(0, 2);
  const double half_deg = ArcCosine_deg((d(2, 2) + s1 * s2) / (c1 * c2));
  std::vector<double> middles_deg = {half_deg, -half_deg};
  if (!movable_[kMiddle]) middles_deg = {rest_deg_[kMiddle]};

  std::vector<Vector3> candidates;
  for (const double middle_deg : middles_deg) {
    const Eigen::Vector3d p = fixed_.outer_middle * AboutX(middle_deg) * fixed_.middle_inner.col(2);
    if (std::hypot(p.x(), p.y()) > 1e-6 && movable_[kOuter]) {
      const double outer_deg = TurnOnto(p.x(), p.y(), d(0, 2), d(1, 2), rest_deg_[kOuter]);
      candidates.push_back(WithOuter(d, middle_deg, outer_deg));
    }
    candidates.push_back(WithOuter(d, middle_deg, rest_deg_[kOuter]));
    candidates.push_back(WithInner(d, middle_deg, rest_deg_[kInner]));
  }
  return candidates;
}

}  // namespace gyrobench::kinematics
