// Frames of the stand: from axis angles and rates to what the sensor feels.
#pragma once

#include <array>
#include <optional>

#include "config/scenario.h"

namespace gyrobench::stand {

using config::Triple;

// Earth's rotation [deg/h].
inline constexpr double kEarthRate_deg_h = 15.041;

// World W (z up), outer axis about W z, middle about the outer frame's x, inner about the middle
// frame's z:
//   R_WS = R_tilt Rz(outer) Ry(e1) Rx(middle) Ry(e2) Rz(inner) R_mount
// with R_tilt = Rx Ry how the base stands, e1 and e2 the lack of squareness of neighbouring axes
// and R_mount = Rz Ry Rx how the sensor sits. All four are I on a perfect stand. Source: docs of
// the measurement table, "Geometry of the stand".
class Geometry {
 public:
  // Without a latitude the Earth does not turn.
  Geometry(const config::SiteScenario& site, std::optional<double> latitude_deg,
           double heading_deg);

  void SetAngles(const Triple& angles_deg);
  // Rate of the sensor against the stand's base, in S, for rates of the axes. Same unit in and out.
  Triple Rate(const Triple& axis_rates) const;
  // Specific force at rest, in S [g].
  Triple Gravity() const { return ToSensor(gravity_); }
  // Earth's rotation in S [deg/s].
  Triple EarthRate() const { return ToSensor(earth_deg_s_); }

 private:
  struct Angle {
    double deg = 0.0, c = 1.0, s = 0.0;
  };
  static Angle MakeAngle(double deg);
  Triple ToSensor(const Triple& v_base) const;
  Triple FromMiddle(Triple v) const;

  Triple gravity_;  // in the base's frame
  Triple earth_deg_s_ = {};
  Angle outer_middle_, middle_inner_;
  std::array<Angle, 3> mount_;
  std::array<Angle, 3> axes_;
};

}  // namespace gyrobench::stand
