#include "stand/geometry.h"

#include <cmath>

#include "base/geometry.h"

namespace gyrobench::stand {
namespace {

// Transposed rotations: components of v in a frame turned by the angle.
Triple TurnX(const Triple& v, double c, double s) {
  return {v[0], c * v[1] + s * v[2], -s * v[1] + c * v[2]};
}
Triple TurnY(const Triple& v, double c, double s) {
  return {c * v[0] - s * v[2], v[1], s * v[0] + c * v[2]};
}
Triple TurnZ(const Triple& v, double c, double s) {
  return {c * v[0] + s * v[1], -s * v[0] + c * v[1], v[2]};
}

}  // namespace

Geometry::Angle Geometry::MakeAngle(double deg) {
  return {.deg = deg, .c = std::cos(deg * kRadPerDeg), .s = std::sin(deg * kRadPerDeg)};
}

Geometry::Geometry(const config::SiteScenario& site, std::optional<double> latitude_deg,
                   double heading_deg)
    : outer_middle_(MakeAngle(site.outer_middle_deg)),
      middle_inner_(MakeAngle(site.middle_inner_deg)) {
  for (std::size_t i = 0; i < 3; ++i) mount_[i] = MakeAngle(site.mount_deg[i]);
  const Angle x = MakeAngle(site.tilt_x_deg);
  const Angle y = MakeAngle(site.tilt_y_deg);
  const auto to_base = [&](const Triple& v) { return TurnY(TurnX(v, x.c, x.s), y.c, y.s); };
  gravity_ = to_base({0.0, 0.0, 1.0});
  if (latitude_deg) {
    const Angle lat = MakeAngle(*latitude_deg);
    const Angle head = MakeAngle(heading_deg);
    const double w = kEarthRate_deg_h / 3600.0;
    earth_deg_s_ = to_base({w * lat.c * head.c, -w * lat.c * head.s, w * lat.s});
  }
}

void Geometry::SetAngles(const Triple& angles_deg) {
  for (std::size_t i = 0; i < 3; ++i) {
    if (axes_[i].deg != angles_deg[i]) axes_[i] = MakeAngle(angles_deg[i]);
  }
}

// From the frame after the middle axis into S.
Triple Geometry::FromMiddle(Triple v) const {
  v = TurnY(v, middle_inner_.c, middle_inner_.s);
  v = TurnZ(v, axes_[2].c, axes_[2].s);
  v = TurnZ(v, mount_[2].c, mount_[2].s);
  v = TurnY(v, mount_[1].c, mount_[1].s);
  return TurnX(v, mount_[0].c, mount_[0].s);
}

Triple Geometry::ToSensor(const Triple& v_base) const {
  Triple v = TurnZ(v_base, axes_[0].c, axes_[0].s);
  v = TurnY(v, outer_middle_.c, outer_middle_.s);
  v = TurnX(v, axes_[1].c, axes_[1].s);
  return FromMiddle(v);
}

Triple Geometry::Rate(const Triple& axis_rates) const {
  Triple v = TurnY({0.0, 0.0, axis_rates[0]}, outer_middle_.c, outer_middle_.s);
  v = TurnX(v, axes_[1].c, axes_[1].s);
  v[0] += axis_rates[1];
  v = TurnY(v, middle_inner_.c, middle_inner_.s);
  v[2] += axis_rates[2];
  v = TurnZ(v, axes_[2].c, axes_[2].s);
  v = TurnZ(v, mount_[2].c, mount_[2].s);
  v = TurnY(v, mount_[1].c, mount_[1].s);
  return TurnX(v, mount_[0].c, mount_[0].s);
}

}  // namespace gyrobench::stand
