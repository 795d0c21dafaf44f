#include "stand/bench_physics.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <string>

#include "base/error.h"
#include "stand/random.h"

namespace gyrobench::stand {
namespace {

using Kind = config::FaultScenario::Kind;

std::string DriveName(std::size_t axis) { return fmt::format("{}.drive", kAxisNames[axis]); }
std::string EncoderName(std::size_t axis) { return fmt::format("{}.encoder", kAxisNames[axis]); }

Geometry GeometryOf(const config::StandConfig& stand, const config::SiteScenario& site) {
  std::optional<double> latitude_deg =
      site.latitude_deg ? site.latitude_deg : stand.site.latitude_deg;
  if (!site.earth_rate) latitude_deg.reset();
  return {site, latitude_deg, site.heading_deg.value_or(stand.site.heading_deg)};
}

const config::GyroUnitMap& Checked(const config::GyroUnitMap& map) {
  if (map.gyro_lsb_per_deg_s.size() < 4 || map.accel_lsb_per_g.size() < 4 ||
      map.filter_bandwidth_hz.size() < 7 || map.filter_delay_s.size() < 7) {
    throw ConfigError(fmt::format(
        "virtual stand: the gyro map '{}' gives {} gyro ranges, {} accelerometer ranges, {} filter "
        "bandwidths and {} delays: expected 4, 4, 7, 7",
        map.model, map.gyro_lsb_per_deg_s.size(), map.accel_lsb_per_g.size(),
        map.filter_bandwidth_hz.size(), map.filter_delay_s.size()));
  }
  return map;
}

}  // namespace

std::size_t AxisIndex(const std::string& name) {
  const auto found = std::ranges::find(kAxisNames, name);
  if (found == kAxisNames.end()) {
    throw ConfigError(
        fmt::format("virtual stand: axis '{}': expected outer, middle or inner", name));
  }
  return static_cast<std::size_t>(found - kAxisNames.begin());
}

Physics::AxisConstants Physics::ConstantsOf(const config::StandConfig& stand, std::size_t axis) {
  for (const auto& configured : stand.axes) {
    if (AxisIndex(configured.name) != axis) continue;
    return {.gear_ratio = configured.drive.sign * configured.gear_ratio,
            .pulses_per_turn = static_cast<double>(configured.drive.map.pulses_per_turn),
            .encoder = configured.encoder};
  }
  return {};
}

AxisMechanics Physics::MakeAxis(std::size_t axis) const {
  const AxisConstants& constants = constants_[axis];
  return {specimen_.mechanics[axis], specimen_.encoder[axis].backlash_deg, constants.gear_ratio,
          constants.pulses_per_turn};
}

AngleEncoder Physics::MakeEncoder(std::size_t axis, std::uint64_t seed) const {
  const AxisConstants& constants = constants_[axis];
  return {specimen_.encoder[axis], constants.encoder, constants.gear_ratio,
          SourceSeed(seed, Source::kEncoder, axis)};
}

Physics::Physics(const config::StandConfig& stand, const config::Scenario& specimen,
                 std::uint64_t seed, Utime start)
    : specimen_(specimen),
      map_(Checked(stand.gyro.map)),
      start_(start),
      constants_{ConstantsOf(stand, 0), ConstantsOf(stand, 1), ConstantsOf(stand, 2)},
      faults_(specimen_, seed),
      axes_{MakeAxis(0), MakeAxis(1), MakeAxis(2)},
      encoders_{MakeEncoder(0, seed), MakeEncoder(1, seed), MakeEncoder(2, seed)},
      gyro_(specimen_, map_, seed, GeometryOf(stand, specimen_.site), faults_) {
  if (stand.virtual_stand && stand.virtual_stand->truth) {
    truth_.emplace(*stand.virtual_stand->truth, start);
  }
}

// Returns the time that counts [s since power-on]: never before what has already happened.
double Physics::Advance(Utime at) {
  now_s_ = std::max(now_s_, ToSeconds(at - start_));
  while (const auto begun = faults_.TakeBegun(now_s_)) {
    gyro_.CatchUp(begun->begin_s, axes_);
    Happen(*begun);
  }
  gyro_.CatchUp(now_s_, axes_);
  if (truth_) truth_->Follow(now_s_, axes_);
  return now_s_;
}

void Physics::Note(double t_s, std::string_view what, std::string_view device, double value) {
  if (!truth_) return;
  truth_->Follow(t_s, axes_);
  truth_->Note(t_s, what, device, value);
}

void Physics::Happen(const Faults::Begun& begun) {
  const config::FaultScenario& fault = begun.fault;
  Note(begun.begin_s, "fault", fault.device, fault.amount);
  if (fault.device == "gyro") {
    if (fault.kind == Kind::kReboot) gyro_.Reboot(begun.begin_s);
    if (fault.kind == Kind::kClockJump) gyro_.JumpClock(fault.amount);
  }
  for (std::size_t axis = 0; axis < axes_.size(); ++axis) {
    if (fault.device == DriveName(axis)) HappenToDrive(axis, begun);
  }
}

void Physics::HappenToDrive(std::size_t axis, const Faults::Begun& begun) {
  const double amount = begun.fault.amount;
  const double quick_ms = specimen_.mechanics[axis].quick_stop_ms_per_1000rpm;
  switch (begun.fault.kind) {
    case Kind::kAlarm:
      alarms_now_[axis] = static_cast<int>(amount);
      axes_[axis].Stop(begun.begin_s, quick_ms);
      break;
    case Kind::kReboot:
      alarms_now_[axis] = 0;
      axes_[axis].Stop(begun.begin_s, quick_ms);
      count_zero_[axis] = std::llround(axes_[axis].Pulses(begun.begin_s));
      break;
    case Kind::kEmergencyStop:
    case Kind::kLimitPlus:
    case Kind::kLimitMinus:
      axes_[axis].Stop(begun.begin_s, quick_ms);
      break;
    case Kind::kLostSteps:
      axes_[axis].Lose(begun.begin_s, amount);
      break;
    case Kind::kJammed:
      axes_[axis].Drag(begun.begin_s, begun.end_s, 1.0);
      break;
    case Kind::kSlipping:
      axes_[axis].Drag(begun.begin_s, begun.end_s, amount);
      break;
    case Kind::kRunaway:
      axes_[axis].RunAway(begun.begin_s, begun.end_s, amount);
      break;
    default:
      break;
  }
}

void Physics::AdvanceTo(Utime at) {
  const std::lock_guard lock(mutex_);
  Advance(at);
}

// A limit holds the way on, not the way back.
bool Physics::InputsPermit(std::size_t axis, double t_s, const MoveCommand& command) const {
  const std::string device = DriveName(axis);
  const bool onwards = static_cast<double>(command.target) > axes_[axis].Pulses(t_s);
  return !faults_.Acting(device, Kind::kEmergencyStop, t_s) &&
         !faults_.Acting(device, onwards ? Kind::kLimitPlus : Kind::kLimitMinus, t_s);
}

void Physics::Start(std::size_t axis, double t_s, const MoveCommand& command) {
  if (alarms_now_[axis] != 0 || !InputsPermit(axis, t_s, command)) return;
  const AxisConstants& constants = constants_[axis];
  if (const auto share = faults_.Acting(EncoderName(axis), Kind::kLoose, t_s)) {
    const double move_deg = (static_cast<double>(command.target) - axes_[axis].Pulses(t_s)) *
                            360.0 / constants.pulses_per_turn / constants.gear_ratio;
    encoder_slip_deg_[axis] -= *share * std::max(0.0, move_deg);
  }
  axes_[axis].Move(t_s, command);
  Note(t_s, "move", kAxisNames[axis],
       static_cast<double>(command.target) * 360.0 / constants.pulses_per_turn /
           constants.gear_ratio);
  faults_.Moved(axis, t_s);
}

void Physics::MoveBy(std::size_t axis, Utime at, std::int64_t pulses, MoveCommand command) {
  const std::lock_guard lock(mutex_);
  const double t_s = Advance(at);
  command.target = std::llround(axes_[axis].Pulses(t_s)) + pulses;
  Start(axis, t_s, command);
}

void Physics::MoveTo(std::size_t axis, Utime at, MoveCommand command) {
  const std::lock_guard lock(mutex_);
  command.target += count_zero_[axis];
  Start(axis, Advance(at), command);
}

void Physics::QuickStop(std::size_t axis, Utime at) {
  const std::lock_guard lock(mutex_);
  const double t_s = Advance(at);
  axes_[axis].Stop(t_s, specimen_.mechanics[axis].quick_stop_ms_per_1000rpm);
  Note(t_s, "stop", kAxisNames[axis]);
}

void Physics::ClearAlarm(std::size_t axis, Utime at) {
  const std::lock_guard lock(mutex_);
  Advance(at);
  alarms_now_[axis] = 0;
}

Physics::DriveView Physics::Drive(std::size_t axis, Utime at) {
  const std::lock_guard lock(mutex_);
  const double t_s = Advance(at);
  const std::string device = DriveName(axis);
  if (!faults_.Acting(device, Kind::kFrozen, t_s)) {
    last_view_[axis] = {.pulses = std::llround(axes_[axis].Pulses(t_s)) - count_zero_[axis],
                        .moving = axes_[axis].Moving(t_s),
                        .alarm = alarms_now_[axis]};
  }
  DriveView view = last_view_[axis];
  view.pulses += std::llround(faults_.Acting(device, Kind::kJump, t_s).value_or(0.0));
  view.emergency_stop = faults_.Acting(device, Kind::kEmergencyStop, t_s).has_value();
  view.limit_plus = faults_.Acting(device, Kind::kLimitPlus, t_s).has_value();
  view.limit_minus = faults_.Acting(device, Kind::kLimitMinus, t_s).has_value();
  return view;
}

std::uint32_t Physics::EncoderCounts(std::size_t axis, Utime at) {
  const std::lock_guard lock(mutex_);
  const double t_s = Advance(at);
  const std::string device = EncoderName(axis);
  if (const auto counts = faults_.Acting(device, Kind::kDropout, t_s)) {
    return static_cast<std::uint32_t>(static_cast<std::int64_t>(*counts));
  }
  if (!faults_.Acting(device, Kind::kFrozen, t_s)) {
    const double jump_deg = faults_.Acting(device, Kind::kJump, t_s).value_or(0.0);
    last_counts_[axis] =
        encoders_[axis].Counts(t_s, axes_[axis], jump_deg + encoder_slip_deg_[axis]);
  }
  return last_counts_[axis];
}

void Physics::SetTemperature(Utime at, double degC) {
  const std::lock_guard lock(mutex_);
  Advance(at);
  gyro_.SetTemperature(degC);
}

void Physics::SetFan(Utime at, bool blows) {
  const std::lock_guard lock(mutex_);
  Advance(at);
  gyro_.SetFan(blows);
}

void Physics::SetHeater(Utime at, bool heats) {
  const std::lock_guard lock(mutex_);
  Note(Advance(at), "heater", "relays", heats ? 1.0 : 0.0);
  gyro_.SetHeater(heats);
}

AxisTruth Physics::Truth(std::size_t axis, Utime at) {
  const std::lock_guard lock(mutex_);
  return axes_[axis].At(Advance(at));
}

namespace {

class Drawer {
 public:
  explicit Drawer(std::uint64_t seed) : stream_(seed, Source::kSpecimen) {}

  // Nobody ships a part beyond its data sheet: the tails are cut.
  void Add(double& value, double sigma) {
    constexpr double kTail = 2.5;
    value += sigma * std::clamp(stream_.Normal(), -kTail, kTail);
  }
  template <std::size_t N>
  void Add(std::array<double, N>& values, double sigma) {
    for (double& value : values) Add(value, sigma);
  }
  void AddOffDiagonal(config::Square& values, double sigma) {
    for (std::size_t i = 0; i < values.size(); ++i) {
      if (i % 4 != 0) Add(values[i], sigma);
    }
  }
  void Phase(double& deg, bool drawn) {
    const double turn = stream_.Uniform();
    if (drawn) deg = 360.0 * turn;
  }

 private:
  RandomStream stream_;
};

void DrawGyro(config::GyroScenario& gyro, const config::DrawnScenario& drawn, Drawer& drawer) {
  drawer.Add(gyro.scale_rel, drawn.gyro_scale_rel);
  drawer.AddOffDiagonal(gyro.cross_axis_rel, drawn.gyro_cross_axis_rel);
  drawer.Add(gyro.scale_temperature_per_degC, drawn.gyro_scale_temperature_per_degC);
  drawer.Add(gyro.bias_deg_s, drawn.gyro_bias_deg_s);
  drawer.Add(gyro.bias_deg_s_per_degC, drawn.gyro_bias_deg_s_per_degC);
  drawer.Add(gyro.bias_deg_s_per_degC2, drawn.gyro_bias_deg_s_per_degC2);
  drawer.Add(gyro.bias_deg_s_per_degC3, drawn.gyro_bias_deg_s_per_degC3);
  drawer.Add(gyro.g_linear_deg_s_per_g, drawn.gyro_g_linear_deg_s_per_g);
  drawer.Add(gyro.g_squared_deg_s_per_g2, drawn.gyro_g_squared_deg_s_per_g2);
  drawer.Add(gyro.sample_clock_rel, drawn.sample_clock_rel);
  for (auto& tone : gyro.tones) drawer.Phase(tone.phase_deg, drawn.phases);
}

void DrawStand(config::Scenario& specimen, const config::DrawnScenario& drawn, Drawer& drawer) {
  for (auto& axis : specimen.mechanics) {
    drawer.Add(axis.clock_rel, drawn.drive_clock_rel);
    drawer.Phase(axis.worm_1_phase_deg, drawn.phases);
    drawer.Phase(axis.worm_2_phase_deg, drawn.phases);
  }
  for (auto& encoder : specimen.encoder) {
    drawer.Phase(encoder.eccentricity_1_phase_deg, drawn.phases);
    drawer.Phase(encoder.eccentricity_2_phase_deg, drawn.phases);
    drawer.Phase(encoder.ripple_phase_deg, drawn.phases);
    drawer.Phase(encoder.worm_1_phase_deg, drawn.phases);
    drawer.Phase(encoder.worm_2_phase_deg, drawn.phases);
  }
}

}  // namespace

config::Scenario DrawSpecimen(const config::Scenario& scenario, std::uint64_t seed) {
  config::Scenario specimen = scenario;
  const config::DrawnScenario& drawn = scenario.drawn;
  Drawer drawer(seed);
  DrawStand(specimen, drawn, drawer);
  drawer.Add(specimen.accelerometer.offset_g, drawn.accelerometer_offset_g);
  drawer.Add(specimen.accelerometer.scale_rel, drawn.accelerometer_scale_rel);
  drawer.AddOffDiagonal(specimen.accelerometer.cross_axis_rel, drawn.accelerometer_cross_axis_rel);
  drawer.Add(specimen.thermal.thermometer_offset_degC, drawn.thermometer_offset_degC);
  drawer.Add(specimen.unit.tick_rel, drawn.tick_rel);
  drawer.Add(specimen.site.mount_deg, drawn.mount_deg);
  DrawGyro(specimen.gyro, drawn, drawer);
  specimen.drawn = config::IdealScenario().drawn;
  return specimen;
}

}  // namespace gyrobench::stand
