#include "kinematics/find_pose.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include "base/error.h"
#include "kinematics/pose_candidates.h"

namespace gyrobench::kinematics {
namespace {

constexpr double kRounding_deg = 1e-6;
// A pose must save more motion than this to be taken before another: where a reference sensor reads
// a little to this or that side must not decide between two ways of one length.
constexpr double kWorthwhile_deg = 2.0;
// Nearer to the direction than this is no reason to move further.
constexpr double kNearEnough_deg = 0.01;
// Of two ways of half a turn the positive one is taken, also where the reading is a little beside
// it.
constexpr double kHalfAndMore = 0.51;
constexpr double kLock_deg = 0.5;
constexpr std::array<const char*, 3> kNames = {"outer", "middle", "inner"};

double Between_deg(const Eigen::Vector3d& a, const Eigen::Vector3d& b) {
  return std::atan2(a.cross(b).norm(), a.dot(b)) / kRadPerDeg;
}

std::optional<Eigen::Vector3d> Unit(const std::optional<Vector3>& v, const char* what) {
  if (!v) return std::nullopt;
  const double length = ToEigen(*v).norm();
  if (!(length > 0.0) || !std::isfinite(length)) {
    throw Error(fmt::format("{} = ({}): expected a direction, a vector of finite length above 0",
                            what, fmt::join(*v, ", ")));
  }
  return ToEigen(*v) / length;
}

void CheckNumbers(const StandGeometry& geometry, const std::array<AxisRange, 3>& axes,
                  const PoseRequest& request) {
  double sum = geometry.outer_middle_deg + geometry.middle_inner_deg + request.tolerance_deg;
  for (const double angle_deg : geometry.mount_deg) sum += angle_deg;
  if (!std::isfinite(sum)) throw Error("the stand's geometry has an angle that is not a number");
  for (std::size_t i = 0; i < axes.size(); ++i) {
    const AxisRange& axis = axes[i];
    if (axis.present && !(std::isfinite(axis.angle_deg) && axis.min_deg <= axis.max_deg)) {
      throw Error(
          fmt::format("axis.{}: angle {} deg, limits {} .. {} deg: expected numbers in order",
                      kNames[i], axis.angle_deg, axis.min_deg, axis.max_deg));
    }
  }
}

class Finder {
 public:
  Finder(const StandGeometry& geometry, const std::array<AxisRange, 3>& axes,
         const PoseRequest& request)
      : frame_(geometry),
        axes_(axes),
        request_(request),
        up_(Unit(request.up, "up")),
        forward_(Unit(request.forward, "forward")),
        about_(Unit(request.about, "about")),
        candidates_(geometry, Rest(axes), Movable(axes)) {
    CheckNumbers(geometry, axes, request);
    CheckRequest();
  }

  PoseAnswer Find() {
    if (about_) {
      TurnInner();
      TurnMiddle();
      TurnOuter();
    } else if (forward_) {
      Eigen::Matrix3d world_axes;  // rows: W's x, y, z in S
      world_axes << forward_->transpose(), up_->cross(*forward_).transpose(), up_->transpose();
      for (const Vector3& angles_deg : candidates_.Holding(world_axes)) Judge(angles_deg);
    } else {
      for (const Vector3& angles_deg : candidates_.OuterAlong(*up_)) Judge(angles_deg);
    }
    if (best_) return {best_, ""};
    return {std::nullopt, reason_};
  }

 private:
  static Vector3 Rest(const std::array<AxisRange, 3>& axes) {
    Vector3 rest_deg = {};
    for (std::size_t i = 0; i < 3; ++i) {
      const AxisRange& axis = axes[i];
      if (axis.present && axis.min_deg <= axis.max_deg)
        rest_deg[i] = std::clamp(axis.angle_deg, axis.min_deg, axis.max_deg);
    }
    return rest_deg;
  }
  static std::array<bool, 3> Movable(const std::array<AxisRange, 3>& axes) {
    return {axes[0].present, axes[1].present, axes[2].present};
  }

  void CheckRequest() const {
    if (!up_ && !about_) throw Error("a pose needs up or about");
    if (request_.axis && !about_) throw Error("axis says which one turns: it needs about");
    if (!forward_) return;
    if (!up_ || about_) throw Error("forward goes with up, and not with about");
    if (std::abs(Between_deg(*up_, *forward_) - 90.0) > 0.1) {
      throw Error(fmt::format("up and forward are {:.4g} deg apart: expected 90 deg",
                              Between_deg(*up_, *forward_)));
    }
  }

  bool MayTurn(StandAxis axis) {
    if (request_.axis && *request_.axis != axis) return false;
    const auto index = static_cast<std::size_t>(axis);
    if (axes_[index].present) return true;
    if (request_.axis) reason_ = fmt::format("this stand has no {} axis", kNames[index]);
    return false;
  }

  void TurnInner() {
    if (!MayTurn(StandAxis::kInner)) return;
    const Vector3 rest_deg = Rest(axes_);
    for (const double sense : {1.0, -1.0}) {
      if (!up_) Judge(rest_deg, StandAxis::kInner, sense);
      if (!up_) continue;
      for (const Vector3& angles_deg : candidates_.OuterAlong(*up_))
        Judge(angles_deg, StandAxis::kInner, sense);
    }
  }

  void TurnMiddle() {
    if (!MayTurn(StandAxis::kMiddle)) return;
    for (const double sense : {1.0, -1.0}) {
      const Vector3 angles_deg = candidates_.MiddleAlong(sense * *about_);
      Judge(up_ ? candidates_.MiddleForUp(angles_deg, *up_) : angles_deg, StandAxis::kMiddle,
            sense);
    }
  }

  void TurnOuter() {
    if (!MayTurn(StandAxis::kOuter)) return;
    for (const double sense : {1.0, -1.0}) {
      for (const Vector3& angles_deg : candidates_.OuterAlong(sense * *about_))
        Judge(angles_deg, StandAxis::kOuter, sense);
    }
  }

  // The largest angle between what was asked for and what these angles give.
  double Off_deg(const Vector3& angles_deg, std::optional<StandAxis> axis, double sense) const {
    const Matrix3 r = frame_.Orientation(angles_deg);
    double off_deg = 0.0;
    if (up_) off_deg = std::max(off_deg, Between_deg(ToEigen(r[2]), *up_));
    if (forward_) off_deg = std::max(off_deg, Between_deg(ToEigen(r[0]), *forward_));
    if (axis) {
      const auto column = static_cast<std::size_t>(*axis);
      const Matrix3 j = frame_.Rates(angles_deg);
      const Eigen::Vector3d direction(j[0][column], j[1][column], j[2][column]);
      off_deg = std::max(off_deg, Between_deg(sense * direction, *about_));
    }
    return off_deg;
  }

  // The same angle, whole turns aside, nearest to where the axis stands.
  double Nearest(std::size_t index, double angle_deg) const {
    const AxisRange& axis = axes_[index];
    if (!axis.present) return angle_deg;
    const double turns = (angle_deg - axis.angle_deg) / 360.0;
    return angle_deg - 360.0 * std::ceil(turns - kHalfAndMore);
  }

  // Of the same angles the nearest one within the limits; nothing where there is none.
  std::optional<double> Fit(std::size_t index, double nearest_deg) const {
    const AxisRange& axis = axes_[index];
    if (!axis.present) return nearest_deg;
    const double min_deg = axis.min_deg - kRounding_deg, max_deg = axis.max_deg + kRounding_deg;
    double fit_deg = nearest_deg;
    if (fit_deg < min_deg) fit_deg += 360.0 * std::ceil((min_deg - fit_deg) / 360.0);
    if (fit_deg > max_deg) fit_deg -= 360.0 * std::ceil((fit_deg - max_deg) / 360.0);
    if (fit_deg < min_deg) return std::nullopt;
    return std::clamp(fit_deg, axis.min_deg, axis.max_deg);
  }

  void Refuse(double off_deg, const std::string& reason) {
    if (off_deg >= least_off_deg_) return;
    least_off_deg_ = off_deg;
    reason_ = reason;
  }

  std::string Missing() const {
    std::string text;
    for (std::size_t i = 0; i < 3; ++i) {
      if (axes_[i].present) continue;
      text += fmt::format("{}{}", text.empty() ? "; the stand has no " : " and no ", kNames[i]);
    }
    return text.empty() ? text : text + " axis";
  }

  bool Locked(const Vector3& angles_deg) const {
    const Matrix3 j = frame_.Rates(angles_deg);
    const Eigen::Vector3d outer(j[0][0], j[1][0], j[2][0]), inner(j[0][2], j[1][2], j[2][2]);
    return outer.cross(inner).norm() < std::sin(kLock_deg * kRadPerDeg);
  }

  void Judge(Vector3 angles_deg, std::optional<StandAxis> axis = {}, double sense = 1.0) {
    const double off_deg = Off_deg(angles_deg, axis, sense);
    if (!(off_deg <= request_.tolerance_deg)) {
      const bool lock = about_ && axes_[1].present && Locked(angles_deg);
      Refuse(off_deg,
             fmt::format("the nearest pose is {:.1f} deg off{}{}", off_deg, Missing(),
                         lock ? "; outer and inner axis are parallel there (gimbal lock)" : ""));
      return;
    }
    double motion_deg = 0.0;
    for (std::size_t i = 0; i < 3; ++i) {
      const double nearest_deg = Nearest(i, angles_deg[i]);
      const std::optional<double> fit_deg = Fit(i, nearest_deg);
      if (!fit_deg) {
        Refuse(-1.0, fmt::format("axis.{} would stand at {:.1f} deg, beyond its limits {:g} .. {:g}"
                                 " deg",
                                 kNames[i], nearest_deg, axes_[i].min_deg, axes_[i].max_deg));
        return;
      }
      angles_deg[i] = *fit_deg;
      if (axes_[i].present) motion_deg += std::abs(*fit_deg - axes_[i].angle_deg);
    }
    Take({angles_deg, axis, sense, off_deg, Locked(angles_deg)}, motion_deg);
  }

  void Take(const Pose& pose, double motion_deg) {
    const bool better = !best_ || pose.off_deg < best_->off_deg - kNearEnough_deg ||
                        (pose.off_deg < best_->off_deg + kNearEnough_deg &&
                         motion_deg < least_motion_deg_ - kWorthwhile_deg);
    if (!better) return;
    best_ = pose;
    least_motion_deg_ = motion_deg;
  }

  const StandFrame frame_;
  const std::array<AxisRange, 3>& axes_;
  const PoseRequest& request_;
  std::optional<Eigen::Vector3d> up_, forward_, about_;
  PoseCandidates candidates_;
  std::optional<Pose> best_;
  double least_motion_deg_ = 0.0;
  double least_off_deg_ = std::numeric_limits<double>::infinity();
  std::string reason_ = "the stand has no axis";
};

}  // namespace

const char* Name(StandAxis axis) { return kNames.at(static_cast<std::size_t>(axis)); }

PoseAnswer FindPose(const StandGeometry& geometry, const std::array<AxisRange, 3>& axes,
                    const PoseRequest& request) {
  return Finder(geometry, axes, request).Find();
}

}  // namespace gyrobench::kinematics
