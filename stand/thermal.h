// Temperature of the sensor.
#pragma once

#include <cstddef>

#include "config/scenario.h"

namespace gyrobench::stand {

// First-order warm-up towards room + self-heating, with a fan, a heater and someone who cools the
// unit:
//   dT/dt = (T_room(t) + heating(t) - T) / tau(t)        package, where the thermometer is
//   dD/dt = (T - D) / lag                                the gyro's element
// Each step is exact for a target that stands still during it. Keeps references to the scenarios.
class Thermal {
 public:
  Thermal(const config::ThermalScenario& thermal, const config::RoomScenario& room);

  // To `t_s`, forwards only.
  void Advance(double t_s);
  // The unit is brought to `degC`, right now.
  void SetTemperature(double degC);
  // Somebody or something switches, beside what the scenario says.
  void SetFan(bool blows) { fan_by_hand_ = blows; }
  void SetHeater(bool heats) { heater_ = heats; }
  // What is around the unit is hotter than the room by this.
  void SetHotter(double degC) { hotter_degC_ = degC; }

  double package_degC() const { return package_degC_; }
  double die_degC() const { return die_degC_; }
  double die_rate_degC_s() const { return die_rate_degC_s_; }
  // What an ideal analogue thermometer with this part's offset and scale says; no noise.
  double Reading_degC() const {
    return 25.0 + (package_degC_ - 25.0) * (1.0 + thermal_.thermometer_scale_rel) +
           thermal_.thermometer_offset_degC;
  }
  double Room(double t_s) const;

 private:
  bool FanBlows(double t_s) const;
  bool ChillWithin(double t_s);
  // 1 - exp(-dt / tau), remembered, for steps are mostly alike.
  struct Fraction {
    double dt_s = -1.0, tau_s = -1.0, value = 0.0;
    double Of(double dt, double tau);
  };

  const config::ThermalScenario& thermal_;
  const config::RoomScenario& room_;
  double t_s_ = 0.0;
  bool fan_by_hand_ = false;
  bool heater_ = false;
  double hotter_degC_ = 0.0;
  double package_degC_, die_degC_;
  double die_rate_degC_s_ = 0.0;
  std::size_t next_chill_ = 0;
  Fraction package_step_, die_step_;
};

}  // namespace gyrobench::stand
