#include "stand/thermal.h"

#include <cmath>
#include <numbers>

namespace gyrobench::stand {

Thermal::Thermal(const config::ThermalScenario& thermal, const config::RoomScenario& room)
    : thermal_(thermal),
      room_(room),
      package_degC_(thermal.start_degC.value_or(Room(0.0))),
      die_degC_(package_degC_) {}

double Thermal::Room(double t_s) const {
  double degC = room_.temperature_degC + room_.drift_degC_per_h * t_s / 3600.0;
  if (room_.swing_degC != 0.0) {
    degC += room_.swing_degC * std::sin(2.0 * std::numbers::pi * t_s / room_.swing_period_s);
  }
  return degC;
}

bool Thermal::FanBlows(double t_s) const {
  for (const auto& fan : room_.fans) {
    if (t_s >= fan.at_s && t_s < fan.at_s + fan.duration_s) return true;
  }
  return false;
}

double Thermal::Fraction::Of(double dt, double tau) {
  if (dt != dt_s || tau != tau_s) {
    dt_s = dt;
    tau_s = tau;
    value = tau > 0.0 ? -std::expm1(-dt / tau) : 1.0;
  }
  return value;
}

bool Thermal::ChillWithin(double t_s) {
  bool chilled = false;
  for (; next_chill_ < thermal_.chills.size() && thermal_.chills[next_chill_].at_s <= t_s;
       ++next_chill_) {
    SetTemperature(thermal_.chills[next_chill_].to_degC);
    chilled = true;
  }
  return chilled;
}

void Thermal::SetTemperature(double degC) {
  package_degC_ = die_degC_ = degC;
  die_rate_degC_s_ = 0.0;
}

void Thermal::Advance(double t_s) {
  const double dt = t_s - t_s_;
  if (!(dt > 0.0)) return;
  t_s_ = t_s;
  if (ChillWithin(t_s)) return;
  const bool fan = fan_by_hand_ || FanBlows(t_s);
  const double heating = thermal_.self_heating_degC - (fan ? room_.fan_drop_degC : 0.0) +
                         (heater_ ? room_.heater_rise_degC : 0.0) + hotter_degC_;
  const double tau = fan ? room_.fan_time_constant_s : thermal_.time_constant_s;
  package_degC_ += package_step_.Of(dt, tau) * (Room(t_s) + heating - package_degC_);
  const double die = die_degC_ + die_step_.Of(dt, thermal_.die_lag_s) * (package_degC_ - die_degC_);
  die_rate_degC_s_ = (die - die_degC_) / dt;
  die_degC_ = die;
}

}  // namespace gyrobench::stand
