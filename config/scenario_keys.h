// The one list of the keys of a scenario file: name, member, unit, range and a line of help. The
// reader and the documentation both walk it (scenario.cc), so a new key is one line here and one
// member in scenario.h.
#pragma once

#include "config/scenario_gyro_keys.h"

namespace gyrobench::config {

template <class V>
void Describe(V& v, RoomScenario::Fan& s) {
  v.Number("at_s", s.at_s, {"s", 0, 1e9, "the fan starts"});
  v.Number("duration_s", s.duration_s, {"s", 0, 1e9, "and blows for so long"});
}

template <class V>
void Describe(V& v, RoomScenario& s) {
  v.Number("temperature_degC", s.temperature_degC, {"degC", -60, 100, "room at power-on"});
  v.Number("drift_degC_per_h", s.drift_degC_per_h, {"degC/h", -50, 50, "slow change of the room"});
  v.Number("swing_degC", s.swing_degC,
           {"degC", 0, 30, "amplitude of a sine of the room (air conditioning)"});
  v.Number("swing_period_s", s.swing_period_s, {"s", 1, 1e6, "its period"});
  v.Number("fan_drop_degC", s.fan_drop_degC, {"degC", 0, 60, "self-heating that a fan takes away"});
  v.Number("fan_time_constant_s", s.fan_time_constant_s,
           {"s", 0.1, 1e5, "time constant while it blows"});
  v.Number("heater_rise_degC", s.heater_rise_degC,
           {"degC", 0, 100, "of the sensor by a heater, at last; 0: it does not heat"});
  v.List("fan", s.fans);
}

template <class V>
void Describe(V& v, ThermalScenario::Chill& s) {
  v.Number("at_s", s.at_s, {"s", 0, 1e9, "someone brings the unit ..."});
  v.Number("to_degC", s.to_degC, {"degC", -60, 125, "... to this temperature and puts it back"});
}

template <class V>
void Describe(V& v, ThermalScenario& s) {
  v.Optional("start_degC", s.start_degC,
             {"degC", -60, 125, "sensor at power-on; without it the room"});
  v.Number("cooled_degC", s.cooled_degC,
           {"degC", -60, 125, "to which the operator cools the unit when asked"});
  v.Number("self_heating_degC", s.self_heating_degC,
           {"degC", 0, 60, "settles so far above the room"});
  v.Number("time_constant_s", s.time_constant_s, {"s", 0.1, 1e5, "of the warm-up"});
  v.Number("die_lag_s", s.die_lag_s,
           {"s", 0, 1e4, "the gyro's element lags behind the thermometer"});
  v.Number("thermometer_offset_degC", s.thermometer_offset_degC,
           {"degC", -50, 50, "thermometer reads high by"});
  v.Number("thermometer_scale_rel", s.thermometer_scale_rel,
           {"1", -0.5, 0.5, "scale error about 25 degC"});
  v.Number("thermometer_noise_degC", s.thermometer_noise_degC,
           {"degC", 0, 10, "standard deviation of a sample"});
  v.List("chill", s.chills);
}

template <class V>
void Describe(V& v, AccelerometerScenario& s) {
  v.Array("offset_g", s.offset_g, {"g", -2, 2, "offset"});
  v.Array("offset_g_per_degC", s.offset_g_per_degC, {"g/degC", -0.1, 0.1, "times T - 25 degC"});
  v.Array("scale_rel", s.scale_rel, {"1", -kMostRel, kMostRel, "scale error"});
  v.Array("cross_axis_rel", s.cross_axis_rel, {"1", -kMostRel, kMostRel, "3x3, off-diagonal"});
  v.Array("noise_g_sqrt_s", s.noise_g_sqrt_s,
          {"g sqrt(s)", 0, 1, "a sample at rate f has noise times sqrt(f)"});
}

template <class V>
void Describe(V& v, UnitScenario& s) {
  v.Integer("serial_number", s.serial_number, {"", 0, 4294967295.0, "of the gyro unit"});
  v.Integer("boot_count", s.boot_count, {"", 0, 60000, "at power-on"});
  v.Number("tick_rel", s.tick_rel, {"1", -kMostRel, kMostRel, "rate error of the tick"});
  v.Number("tick_rel_per_degC", s.tick_rel_per_degC,
           {"1/degC", -0.001, 0.001, "times T - 25 degC"});
  v.Number("tick_drift_rel_per_h", s.tick_drift_rel_per_h,
           {"1/h", -0.01, 0.01, "ageing of the tick rate"});
  v.Number("tick_jitter_s", s.tick_jitter_s,
           {"s", 0, 0.0009, "time stamp late by up to this, uniform"});
  v.Number("lost_sample_probability", s.lost_sample_probability,
           {"1", 0, 1, "a sample is not read in time"});
  v.Number("boot_time_s", s.boot_time_s, {"s", 0, 60, "silent after a reboot"});
}

template <class V>
void Describe(V& v, MechanicsScenario& s) {
  v.Number("clock_rel", s.clock_rel,
           {"1", -kMostRel, kMostRel, "rate error of the drive's pulses"});
  v.Number("pull_out_rpm_per_s", s.pull_out_rpm_per_s,
           {"rpm/s", 1, 1e9, "beyond this acceleration of the shaft the motor slips"});
  v.Number("quick_stop_ms_per_1000rpm", s.quick_stop_ms_per_1000rpm,
           {"ms", 1, 32767, "ramp of the quick stop"});
  v.Number("worm_1_deg", s.worm_1_deg, {"deg", 0, 1, "table angle once per shaft turn, amplitude"});
  v.Number("worm_1_phase_deg", s.worm_1_phase_deg,
           {"deg", -360, 360, "its phase (drawn when drawn.phases)"});
  v.Number("worm_2_deg", s.worm_2_deg, {"deg", 0, 0.5, "twice per shaft turn"});
  v.Number("worm_2_phase_deg", s.worm_2_phase_deg,
           {"deg", -360, 360, "its phase (drawn when drawn.phases)"});
  v.Number("backlash_deg", s.backlash_deg, {"deg", 0, 10, "full width of the play, table side"});
  v.Number("ripple_deg", s.ripple_deg,
           {"deg", 0, 1, "table angle, amplitude of the motor's ripple"});
  v.Number("ripple_per_turn", s.ripple_per_turn, {"1", 0, 1e5, "periods per shaft turn"});
  v.Number("resonance_deg_s", s.resonance_deg_s,
           {"deg/s", 0, 1000, "table rate at which the steps excite the stand"});
  v.Number("resonance_width_deg_s", s.resonance_width_deg_s,
           {"deg/s", 1e-6, 1000, "half-width of the resonance"});
  v.Number("resonance_ripple_deg", s.resonance_ripple_deg,
           {"deg", 0, 10, "ripple's extra amplitude there"});
  v.Number("resonance_vibration_g", s.resonance_vibration_g, {"g", 0, 100, "rms vibration there"});
}

template <class V>
void Describe(V& v, EncoderScenario& s) {
  using Side = EncoderScenario::Side;
  v.Choice("side", s.side, {{"table", Side::kTable}, {"shaft", Side::kShaft}},
           "what it is fixed to");
  v.Number("noise_deg", s.noise_deg, {"deg", 0, 10, "standard deviation of a value"});
  v.Number("latency_s", s.latency_s, {"s", 0, 1, "age of a value when it is given"});
  v.Number("clock_drift_rel", s.clock_drift_rel,
           {"1", -0.01, 0.01, "the latency grows so much per second"});
  v.Number("refresh_s", s.refresh_s, {"s", 1e-6, 1, "a new value so often"});
  v.Number("zero_deg", s.zero_deg, {"deg", -360, 360, "reads high by"});
  v.Number("scale_rel", s.scale_rel,
           {"1", -kMostRel, kMostRel, "scale error (wrong counts per turn)"});
  v.Number("eccentricity_1_deg", s.eccentricity_1_deg,
           {"deg", 0, 10, "once per table turn, amplitude"});
  v.Number("eccentricity_1_phase_deg", s.eccentricity_1_phase_deg,
           {"deg", -360, 360, "its phase (drawn when drawn.phases)"});
  v.Number("eccentricity_2_deg", s.eccentricity_2_deg, {"deg", 0, 10, "twice per table turn"});
  v.Number("eccentricity_2_phase_deg", s.eccentricity_2_phase_deg,
           {"deg", -360, 360, "its phase (drawn when drawn.phases)"});
  v.Number("ripple_deg", s.ripple_deg, {"deg", 0, 10, "own periodic error, amplitude"});
  v.Number("ripple_per_turn", s.ripple_per_turn, {"1", 0, 1e6, "its periods per table turn"});
  v.Number("ripple_phase_deg", s.ripple_phase_deg,
           {"deg", -360, 360, "its phase (drawn when drawn.phases)"});
  v.Number("worm_1_deg", s.worm_1_deg,
           {"deg", 0, 10, "error in step with the shaft, once per its turn"});
  v.Number("worm_1_phase_deg", s.worm_1_phase_deg,
           {"deg", -360, 360, "its phase (drawn when drawn.phases)"});
  v.Number("worm_2_deg", s.worm_2_deg, {"deg", 0, 10, "twice per shaft turn"});
  v.Number("worm_2_phase_deg", s.worm_2_phase_deg,
           {"deg", -360, 360, "its phase (drawn when drawn.phases)"});
  v.Number("backlash_deg", s.backlash_deg,
           {"deg", 0, 10, "full width of the play in its coupling"});
  v.Number("step_at_s", s.step_at_s, {"s", 0, 1e9, "from here on its zero is ..."});
  v.Number("step_deg", s.step_deg, {"deg", -360, 360, "... higher by this much"});
}

template <class V>
void Describe(V& v, BusScenario& s) {
  v.Number("turnaround_s", s.turnaround_s, {"s", 0, 1, "from request to reply, inside a device"});
  v.Number("tcp_latency_s", s.tcp_latency_s, {"s", 0, 1, "Modbus TCP, one way"});
}

template <class V>
void Describe(V& v, SiteScenario& s) {
  v.Flag("earth_rate", s.earth_rate, "the Earth turns");
  v.Optional("latitude_deg", s.latitude_deg,
             {"deg", -90, 90, "truth; without it the stand file's"});
  v.Optional("heading_deg", s.heading_deg,
             {"deg", -360, 360, "truth; without it the stand file's"});
  v.Number("tilt_x_deg", s.tilt_x_deg, {"deg", -10, 10, "the stand's base leans about x"});
  v.Number("tilt_y_deg", s.tilt_y_deg, {"deg", -10, 10, "and about y"});
  v.Number("outer_middle_deg", s.outer_middle_deg,
           {"deg", -10, 10, "outer and middle axis are not square by"});
  v.Number("middle_inner_deg", s.middle_inner_deg,
           {"deg", -10, 10, "middle and inner axis are not square by"});
  v.Array("mount_deg", s.mount_deg,
          {"deg", -180, 180, "sensor turned on the table about x, y, z (Rz Ry Rx)"});
}

template <class V>
void Describe(V& v, DrawnScenario& s) {
  v.Flag("phases", s.phases, "phases of worm, encoder errors and tones at random");
  v.Number("gyro_scale_rel", s.gyro_scale_rel, {"1", 0, 0.1, "spread of gyro.scale_rel"});
  v.Number("gyro_cross_axis_rel", s.gyro_cross_axis_rel, {"1", 0, 0.1, "of gyro.cross_axis_rel"});
  v.Number("gyro_scale_temperature_per_degC", s.gyro_scale_temperature_per_degC,
           {"1/degC", 0, 0.01, "of gyro.scale_temperature_per_degC"});
  v.Number("gyro_bias_deg_s", s.gyro_bias_deg_s, {"deg/s", 0, 100, "of gyro.bias_deg_s"});
  v.Number("gyro_bias_deg_s_per_degC", s.gyro_bias_deg_s_per_degC,
           {"deg/s/degC", 0, 10, "of gyro.bias_deg_s_per_degC"});
  v.Number("gyro_bias_deg_s_per_degC2", s.gyro_bias_deg_s_per_degC2,
           {"deg/s/degC2", 0, 1, "of gyro.bias_deg_s_per_degC2"});
  v.Number("gyro_bias_deg_s_per_degC3", s.gyro_bias_deg_s_per_degC3,
           {"deg/s/degC3", 0, 0.1, "of gyro.bias_deg_s_per_degC3"});
  v.Number("gyro_g_linear_deg_s_per_g", s.gyro_g_linear_deg_s_per_g,
           {"deg/s/g", 0, 10, "of gyro.g_linear_deg_s_per_g"});
  v.Number("gyro_g_squared_deg_s_per_g2", s.gyro_g_squared_deg_s_per_g2,
           {"deg/s/g2", 0, 10, "of gyro.g_squared_deg_s_per_g2"});
  v.Number("sample_clock_rel", s.sample_clock_rel, {"1", 0, 0.1, "of gyro.sample_clock_rel"});
  v.Number("accelerometer_offset_g", s.accelerometer_offset_g,
           {"g", 0, 1, "of accelerometer.offset_g"});
  v.Number("accelerometer_scale_rel", s.accelerometer_scale_rel,
           {"1", 0, 0.1, "of accelerometer.scale_rel"});
  v.Number("accelerometer_cross_axis_rel", s.accelerometer_cross_axis_rel,
           {"1", 0, 0.1, "of accelerometer.cross_axis_rel"});
  v.Number("thermometer_offset_degC", s.thermometer_offset_degC,
           {"degC", 0, 20, "of thermal.thermometer_offset_degC"});
  v.Number("tick_rel", s.tick_rel, {"1", 0, 0.1, "of unit.tick_rel"});
  v.Number("drive_clock_rel", s.drive_clock_rel, {"1", 0, 0.1, "of mechanics.clock_rel"});
  v.Number("mount_deg", s.mount_deg, {"deg", 0, 10, "of site.mount_deg"});
}

template <class V>
void Describe(V& v, FaultScenario& s) {
  using Kind = FaultScenario::Kind;
  using On = FaultScenario::On;
  using Mover = FaultScenario::Mover;
  v.Number("at_s", s.at_s, {"s", 0, 1e9, "begins, counted from `on`"});
  v.Duration("duration_s", s.duration_s, {"s", 0, 1e9, "lasts; without it for ever"});
  v.Device("device", s.device, "gyro, relays, outer.drive, outer.encoder, ... inner.encoder");
  v.Choice("kind", s.kind,
           {{"silent", Kind::kSilent},
            {"garbage", Kind::kGarbage},
            {"bad_crc", Kind::kBadCrc},
            {"late", Kind::kLate},
            {"exception", Kind::kException},
            {"stale", Kind::kStale},
            {"wrong_identity", Kind::kWrongIdentity},
            {"reboot", Kind::kReboot},
            {"frozen", Kind::kFrozen},
            {"jump", Kind::kJump},
            {"dropout", Kind::kDropout},
            {"loose", Kind::kLoose},
            {"saturation", Kind::kSaturation},
            {"overheating", Kind::kOverheating},
            {"clock_jump", Kind::kClockJump},
            {"alarm", Kind::kAlarm},
            {"lost_steps", Kind::kLostSteps},
            {"jammed", Kind::kJammed},
            {"slipping", Kind::kSlipping},
            {"emergency_stop", Kind::kEmergencyStop},
            {"limit_plus", Kind::kLimitPlus},
            {"limit_minus", Kind::kLimitMinus},
            {"runaway", Kind::kRunaway}},
           "what fails; see Faults");
  v.Number("amount", s.amount, {"", -1e9, 1e9, "how much; see Faults"});
  v.Choice("on", s.on, {{"power_on", On::kPowerOn}, {"move", On::kMove}, {"request", On::kRequest}},
           "what at_s counts from: power-on, a move of an axis, a request to the device");
  v.Choice("axis", s.axis,
           {{"own", Mover::kOwn},
            {"outer", Mover::kOuter},
            {"middle", Mover::kMiddle},
            {"inner", Mover::kInner}},
           "whose move; own: the device's axis, of gyro and relays any");
  v.Integer("count", s.count, {"", 1, 1e9, "which move or request it is, from power-on"});
  v.Number("probability", s.probability,
           {"1", 0, 1, "of the line: that a request is hit; else: that it happens at all"});
}

template <class V>
void Describe(V& v, Scenario& s) {
  v.Section("room", s.room);
  v.Section("thermal", s.thermal);
  v.Section("gyro", s.gyro);
  v.Section("accelerometer", s.accelerometer);
  v.Section("unit", s.unit);
  v.PerAxis("mechanics", s.mechanics);
  v.PerAxis("encoder", s.encoder);
  v.Section("bus", s.bus);
  v.Section("site", s.site);
  v.Section("drawn", s.drawn);
  v.List("fault", s.faults);
}

}  // namespace gyrobench::config
