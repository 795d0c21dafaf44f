// A simulation scenario: every imperfection of the virtual stand, with unit and default. Plain
// structs; a scenario file sets what it names (LoadScenario). Times are seconds since the stand's
// power-on.
//
// The defaults are a typical MPU-6050 on a good stand (hardware data sheet, docs of the stand).
// What a part has but a first calibration does not look for (nonlinearity, hysteresis, ...) is zero
// until a file asks. Signs and units of the gyro's terms: output in deg/s = M w + b(T) + sum of
// terms + noise, w the true rate of the sensor [deg/s], g the specific force in the sensor frame
// [g].
#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <limits>
#include <optional>
#include <string>
#include <vector>

namespace gyrobench::config {

using Triple = std::array<double, 3>;  // sensor axes x, y, z
using Square = std::array<double, 9>;  // 3 x 3, row by row; row = axis whose output changes

// The room and what is done in it.
struct RoomScenario {
  struct Fan {
    double at_s = 0.0;
    double duration_s = 0.0;
  };
  double temperature_degC = 22.0;
  double drift_degC_per_h = 0.0;
  double swing_degC = 0.0;  // amplitude
  double swing_period_s = 1200.0;
  double fan_drop_degC = 11.0;         // self-heating that the fan takes away
  double fan_time_constant_s = 120.0;  // of the sensor while the fan blows
  double heater_rise_degC = 15.0;      // of the sensor, at last, with the heater on
  std::vector<Fan> fans;
};

// Temperature of the sensor: first order towards room + self-heating.
struct ThermalScenario {
  struct Chill {  // someone cools (or heats) the unit and puts it back
    double at_s = 0.0;
    double to_degC = -10.0;
  };
  std::optional<double> start_degC;  // at power-on; without it the room's
  double cooled_degC = -10.0;        // what the operator brings the unit to when asked to cool it
  double self_heating_degC = 16.0;
  double time_constant_s = 250.0;
  double die_lag_s = 0.0;  // the gyro's element follows the thermometer with this lag
  double thermometer_offset_degC = 0.0;
  double thermometer_scale_rel = 0.0;  // about 25 degC
  double thermometer_noise_degC = 0.05;
  std::vector<Chill> chills;
};

// The gyro chip, all three axes.
struct GyroScenario {
  struct BiasStep {
    double at_s = 0.0;
    Triple deg_s = {};
  };
  struct Tone {
    double frequency_hz = 50.0;
    double phase_deg = 0.0;
    Triple deg_s = {};  // amplitude
  };
  double reference_degC = 25.0;  // T0 of every polynomial in temperature
  Triple scale_rel = {};         // diagonal of M, less 1
  Square cross_axis_rel = {};    // off-diagonal of M; the diagonal must be 0
  Triple scale_temperature_per_degC = {};
  Triple scale_temperature_per_degC2 = {};
  Triple bias_deg_s = {};
  Triple bias_deg_s_per_degC = {};
  Triple bias_deg_s_per_degC2 = {};
  Triple bias_deg_s_per_degC3 = {};
  // A bias that jumps where the temperature passes a value, as some real parts do.
  double bias_jump_at_degC = 25.0;
  Triple bias_jump_deg_s = {};
  Square g_linear_deg_s_per_g = {};
  Square g_linear_deg_s_per_g_per_degC = {};
  Square g_squared_deg_s_per_g2 = {};
  Square scale_g_per_g = {};             // c g_j w_i
  Triple quadratic_odd_per_deg_s = {};   // c w |w|
  Triple quadratic_even_per_deg_s = {};  // c w^2
  Triple cubic_per_deg2_s2 = {};         // c w^3
  Triple asymmetry_rel = {};             // c |w|
  Triple temperature_rate_deg_s_per_degC_s = {};
  double hysteresis_play_degC = 2.0;  // half-width of the play
  Triple hysteresis_deg_s_per_degC = {};
  double warm_up_time_constant_s = 60.0;  // since power-on
  Triple warm_up_deg_s = {};
  Triple vibration_deg_s_per_g2 = {};  // rectification of the table's vibration
  std::vector<BiasStep> bias_steps;
  std::vector<Tone> tones;
  Triple angle_random_walk_deg_sqrt_s = {0.0035, 0.0035, 0.0035};
  Triple bias_random_walk_deg_s_sqrt_s = {1e-4, 1e-4, 1e-4};
  Triple flicker_deg_s = {};         // bias instability: flat of the Allan deviation / 0.664
  double heavy_tail_fraction = 0.0;  // of samples whose noise is larger ...
  double heavy_tail_factor = 10.0;   // ... by this factor
  double filter_delay_rel = 0.0;     // error of the data sheet's group delay
  double extra_lag_s = 0.0;          // first-order lag before the filter
  double sample_clock_rel = 0.0;  // rate error of the sensor's own clock (sets the sample instants)
};

struct AccelerometerScenario {
  Triple offset_g = {};
  Triple offset_g_per_degC = {};
  Triple scale_rel = {};
  Square cross_axis_rel = {};
  Triple noise_g_sqrt_s = {4e-4, 4e-4, 4e-4};  // data sheet: 400 ug/sqrt(Hz)
};

// The microcontroller.
struct UnitScenario {
  std::uint32_t serial_number = 1001;
  int boot_count = 7;
  double tick_rel = 0.0;           // rate error of the tick, ceramic resonator
  double tick_rel_per_degC = 0.0;  // about 25 degC
  double tick_drift_rel_per_h = 0.0;
  double tick_jitter_s = 4e-6;  // time stamp late by up to this (interrupt latency)
  double lost_sample_probability = 0.0;
  double boot_time_s = 0.1;  // silent after a reboot
};

// Motor, worm and table of one axis.
struct MechanicsScenario {
  double clock_rel = 0.0;               // rate error of the drive's pulses
  double pull_out_rpm_per_s = 60000.0;  // beyond this acceleration the motor slips
  double quick_stop_ms_per_1000rpm = 50.0;
  double worm_1_deg = 0.01;  // table angle, amplitude, once per shaft turn
  double worm_1_phase_deg = 0.0;
  double worm_2_deg = 0.003;  // twice per shaft turn
  double worm_2_phase_deg = 0.0;
  double backlash_deg = 0.02;  // full width of the play, table side
  double ripple_deg = 0.0002;  // table angle, amplitude away from resonance
  double ripple_per_turn =
      50.0;  // periods per shaft turn: 50 = electrical period of a 1.8 deg motor
  double resonance_deg_s = 9.0;  // table rate at which the motor's steps excite the stand
  double resonance_width_deg_s = 1.0;
  double resonance_ripple_deg = 0.0;   // ripple's extra amplitude at resonance
  double resonance_vibration_g = 0.0;  // rms of the vibration at resonance
};

// Reference angle sensor of one axis.
struct EncoderScenario {
  enum class Side { kTable, kShaft };
  Side side = Side::kTable;  // what it is fixed to; on the shaft it sees no worm, play or ripple
  double noise_deg = 0.002;
  double latency_s = 0.0005;
  double clock_drift_rel = 0.0;  // its latency grows by this much per second
  double refresh_s = 0.0001;     // it computes a new value so often
  double zero_deg = 0.0;
  double scale_rel = 0.0;
  double eccentricity_1_deg = 0.003;
  double eccentricity_1_phase_deg = 0.0;
  double eccentricity_2_deg = 0.001;
  double eccentricity_2_phase_deg = 0.0;
  double ripple_deg = 0.0;  // own periodic error
  double ripple_per_turn = 360.0;
  double ripple_phase_deg = 0.0;
  double worm_1_deg = 0.0;  // error in step with the shaft, once per turn
  double worm_1_phase_deg = 0.0;
  double worm_2_deg = 0.0;
  double worm_2_phase_deg = 0.0;
  double backlash_deg = 0.0;  // full width of the play in its coupling
  double step_at_s = 0.0;     // its zero jumps ...
  double step_deg = 0.0;      // ... by this much
};

// The lines.
struct BusScenario {
  double turnaround_s = 0.0005;   // from request to reply, inside a device
  double tcp_latency_s = 0.0003;  // one way
};

// The place, and how well the stand stands.
struct SiteScenario {
  bool earth_rate = true;
  std::optional<double> latitude_deg;  // without it the stand file's; without that no Earth's rate
  std::optional<double> heading_deg;
  double tilt_x_deg = 0.0;  // of the stand's base about its x and y
  double tilt_y_deg = 0.0;
  double outer_middle_deg = 0.0;  // lack of squareness between axes
  double middle_inner_deg = 0.0;
  Triple mount_deg = {};  // sensor on the table: small turns about x, y, z
};

// Standard deviations from specimen to specimen: what the seed draws and adds to the values above.
struct DrawnScenario {
  bool phases = true;  // phases of worm, eccentricity, ripple and tones at random
  double gyro_scale_rel = 0.015;
  double gyro_cross_axis_rel = 0.01;
  double gyro_scale_temperature_per_degC = 1e-4;
  double gyro_bias_deg_s = 2.0;
  double gyro_bias_deg_s_per_degC = 0.03;
  double gyro_bias_deg_s_per_degC2 = 3e-4;
  double gyro_bias_deg_s_per_degC3 = 5e-6;
  double gyro_g_linear_deg_s_per_g = 0.03;
  double gyro_g_squared_deg_s_per_g2 = 0.0;
  double sample_clock_rel = 0.003;
  double accelerometer_offset_g = 0.02;
  double accelerometer_scale_rel = 0.01;
  double accelerometer_cross_axis_rel = 0.01;
  double thermometer_offset_degC = 0.5;
  double tick_rel = 0.001;
  double drive_clock_rel = 3e-5;
  double mount_deg = 0.0;
};

// Something that fails. `device`: gyro, relays, <axis>.drive, <axis>.encoder.
struct FaultScenario {
  enum class Kind {
    // Of the line; each device may have them.
    kSilent,         // no reply
    kGarbage,        // random bytes instead of a reply
    kBadCrc,         // RTU: checksum wrong; TCP: transaction number wrong
    kLate,           // reply later by `amount` [s]
    kException,      // refuses with exception `amount`; 0: 4, device failure
    kStale,          // its reply is the one to the request before
    kWrongIdentity,  // says it is another device
    kReboot,         // loses power for an instant; a drive then is disabled and counts from 0
    // Of a device.
    kFrozen,       // gyro, encoder, drive: repeats its last value
    kJump,         // encoder: reads high by `amount` [deg]; gyro [deg/s]; drive [pulses]
    kDropout,      // encoder: gives `amount` [counts] instead of the angle
    kLoose,        // encoder: stays behind by the share `amount` of each positive move that begins
    kSaturation,   // gyro: all rates at the end of the range, the lower one where `amount` < 0
    kOverheating,  // gyro: surroundings hotter by `amount` [degC]
    kClockJump,    // gyro: the unit's tick leaps by `amount` [s]
    // Of a drive and what it moves.
    kAlarm,          // alarm with code `amount`; motion stops
    kLostSteps,      // the motor loses `amount` pulses in the first motion from the begin on
    kJammed,         // the shaft stands still while the drive counts
    kSlipping,       // of each turn of the drive's count the shaft loses the share `amount`
    kEmergencyStop,  // its input acts: motion stops, the drive is disabled
    kLimitPlus,      // its limit input acts: motion stops, and begins no more that way
    kLimitMinus,
    kRunaway,  // the shaft turns the table by `amount` [deg/s], unknown to the drive, until stopped
  };
  // What `at_s` counts from.
  enum class On {
    kPowerOn,
    kMove,     // the drive of `axis` takes its move number `count`
    kRequest,  // the device takes its request number `count`
  };
  enum class Mover { kOwn, kOuter, kMiddle, kInner };  // own: the device's axis; without one, any

  double at_s = 0.0;
  double duration_s = std::numeric_limits<double>::infinity();
  std::string device;
  Kind kind = Kind::kSilent;
  double amount = 0.0;
  On on = On::kPowerOn;
  Mover axis = Mover::kOwn;
  std::int64_t count = 1;
  // Of the line: that a request is hit. Else: that it happens at all. The seed draws.
  double probability = 1.0;
};

struct Scenario {
  std::string name = "typical";
  RoomScenario room;
  ThermalScenario thermal;
  GyroScenario gyro;
  AccelerometerScenario accelerometer;
  UnitScenario unit;
  std::array<MechanicsScenario, 3> mechanics;  // outer, middle, inner
  std::array<EncoderScenario, 3> encoder;
  BusScenario bus;
  SiteScenario site;
  DrawnScenario drawn;
  std::vector<FaultScenario> faults;
};

// No imperfection but quantisation: every error, noise and spread zero, sensor at room temperature.
Scenario IdealScenario();

// Reads and checks a scenario file. `based_on = "ideal"` starts from IdealScenario(), without it
// from the defaults. Throws ConfigError: file, line, key, value and range; an unknown key is an
// error.
Scenario LoadScenario(const std::filesystem::path& file);
// Reads a file of nothing but [[fault]] tables. Throws ConfigError as LoadScenario.
std::vector<FaultScenario> LoadFaults(const std::filesystem::path& file);

// One key that a scenario file may set, for documentation and its test.
struct ScenarioKey {
  std::string key;  // "gyro.scale_rel"
  std::string unit;
  std::string default_value;
  std::string range;
  std::string help;
};
std::vector<ScenarioKey> ScenarioKeys();

}  // namespace gyrobench::config
