#include "drivers/stepper_axis.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "base/error.h"
#include "config/drive_rates.h"
#include "config/words.h"

namespace gyrobench::drivers {
namespace {

constexpr int kMoveTries = 3;
constexpr int kStopTries = 3;
// How often, and how far apart, a drive is asked whether it has done what it was told.
constexpr int kSettleReads = 10;
constexpr Utime kSettlePause_us = 20'000;

double Pulses(const config::AxisConfig& config, double angle_deg) {
  return config.drive.sign * angle_deg / 360.0 * config.gear_ratio *
         config.drive.map.pulses_per_turn;
}

int PlanRpm(const config::AxisConfig& config, double rate_deg_s) {
  const config::DriveMap& map = config.drive.map;
  const double deg_s_per_rpm = config::DegSPerRpm(config);
  const double rpm = rate_deg_s / deg_s_per_rpm;
  double whole = std::round(rpm);
  constexpr double kRoundingError = 1e-9;
  if (whole * deg_s_per_rpm > config.max_rate_deg_s * (1 + kRoundingError)) whole = std::floor(rpm);
  if (!(whole >= map.min_rpm && whole <= map.max_rpm)) {
    throw LimitError(
        fmt::format("axis.{}: rate {} deg/s is {:.3f} rpm of the shaft; the drive ({}) takes whole "
                    "rpm from {} to "
                    "{}, i.e. {:.4g} to {:.4g} deg/s of the table",
                    config.name, rate_deg_s, rpm, map.model, map.min_rpm, map.max_rpm,
                    config::SlowestRate_deg_s(config), config::FastestRate_deg_s(config)));
  }
  return static_cast<int>(whole);
}

int PlanRamp(const config::AxisConfig& config, double acceleration_deg_s2) {
  const config::DriveMap& map = config.drive.map;
  const double ramp_ms = config::RampPer1000Rpm_ms(config, acceleration_deg_s2);
  constexpr double kRoundingError_ms = 1e-6;
  const double whole =
      std::max(1.0 * map.min_ramp_ms_per_1000rpm, std::ceil(ramp_ms - kRoundingError_ms));
  if (!(acceleration_deg_s2 > 0 && whole <= map.max_ramp_ms_per_1000rpm)) {
    throw LimitError(fmt::format(
        "axis.{}: acceleration {} deg/s^2 needs a ramp of {:.0f} ms per 1000 rpm; the drive ({}) "
        "takes "
        "{} to {}, so at least {:.4g} deg/s^2",
        config.name, acceleration_deg_s2, ramp_ms, map.model, map.min_ramp_ms_per_1000rpm,
        map.max_ramp_ms_per_1000rpm, config::SlowestAcceleration_deg_s2(config)));
  }
  return static_cast<int>(whole);
}

}  // namespace

StepperMove PlanStepperMove(const config::AxisConfig& config, double remainder_pulses,
                            double angle_deg, double rate_deg_s, double acceleration_deg_s2) {
  const double exact = Pulses(config, angle_deg) + remainder_pulses;
  const double whole = std::round(exact);
  constexpr double kMost = std::numeric_limits<std::int32_t>::max();
  if (!(std::fabs(whole) <= kMost)) {
    throw LimitError(
        fmt::format("axis.{}: a move of {} deg is {:.0f} pulses; the drive takes at most {:.0f}",
                    config.name, angle_deg, exact, kMost));
  }
  if (whole == 0) {
    throw LimitError(fmt::format("axis.{}: a move of {} deg is less than one pulse ({:.3g} deg)",
                                 config.name, angle_deg, 1 / std::fabs(Pulses(config, 1.0))));
  }
  StepperMove move;
  move.pulses = static_cast<std::int32_t>(whole);
  move.remainder_pulses = exact - whole;
  move.rpm = static_cast<std::uint16_t>(PlanRpm(config, rate_deg_s));
  move.ramp_ms_per_1000rpm = static_cast<std::uint16_t>(PlanRamp(config, acceleration_deg_s2));
  move.rate_deg_s = move.rpm * config::DegSPerRpm(config);
  return move;
}

StepperAxis::StepperAxis(const config::AxisConfig& config, ModbusBus& bus)
    : config_(config),
      map_(config_.drive.map),
      unit_{"axis." + config.name + " drive", config.drive.unit},
      bus_(bus) {
  if (!(std::fabs(config.gear_ratio) > 0) || map_.pulses_per_turn <= 0) {
    throw ConfigError(
        fmt::format("axis.{}: gear_ratio = {} and pulses_per_turn = {}: neither may be 0",
                    config.name, config.gear_ratio, map_.pulses_per_turn));
  }
}

// The device's name is added to `fields`.
void StepperAxis::Fail(const std::string& text, DeviceFailure fields) const {
  fields.device = unit_.name;
  throw DeviceError(
      fmt::format("{} ({}, unit {}): {}", unit_.name, bus_.description(), unit_.unit, text),
      fields);
}

std::uint16_t StepperAxis::ReadWord(std::uint16_t address, const char* what) {
  std::array<std::uint16_t, 1> word = {};
  bus_.ReadHolding(unit_, address, word, what);
  return word[0];
}

bool StepperAxis::IsMoving() {
  return config::IsBitSet(ReadWord(map_.status_address, "status"), map_.running_bit);
}

int StepperAxis::PulsesPerTurn() {
  return ReadWord(map_.pulses_per_turn_address, "pulses per turn");
}

AxisState StepperAxis::Open() {
  const int pulses = PulsesPerTurn();
  if (pulses != map_.pulses_per_turn) {
    Fail(fmt::format("pulses per turn at 0x{:04X}: expected {} (by the stand file or the map of "
                     "{}), found {}. Stop the daemon and let gyrobench devices --write set the "
                     "drive to {}, or correct pulses_per_turn of {} in the stand file.",
                     map_.pulses_per_turn_address, map_.pulses_per_turn, map_.model, pulses,
                     map_.pulses_per_turn, unit_.name),
         {.action = "pulses per turn", .address = map_.pulses_per_turn_address});
  }
  position_known_ = false;
  remainder_pulses_ = 0.0;
  const AxisState state = Read();
  if (state.fault) {
    Fail(fmt::format("reports a fault, alarm 0x{:X}. Remove its cause and clear the alarm.",
                     state.alarm),
         {.action = "open", .code_kind = DeviceFailure::CodeKind::kAlarm, .code = state.alarm});
  }
  if (state.emergency_stop) {
    Fail("its emergency stop input acts, so that it cannot be enabled. Release the emergency stop.",
         {.action = "open", .address = map_.inputs->address});
  }
  if (!state.enabled) Enable();
  return state;
}

void StepperAxis::Enable() {
  // What keeps it from being enabled may keep the 1 from being read back as well: the status tells.
  bus_.WriteRegister(unit_, map_.enable_address, 1, "enable");
  const std::uint16_t back = ReadWord(map_.enable_address, "enable");
  std::uint16_t status = 0;
  for (int reads = 0; reads < kSettleReads; ++reads) {
    status = ReadWord(map_.status_address, "status");
    if (config::IsBitSet(status, map_.enabled_bit)) return;
    if (bus_.hurries()) break;
    bus_.Wait(kSettlePause_us);
  }
  Fail(fmt::format("does not become enabled: status 0x{:04X}, expected bit {} set; 0x{:04X} was "
                   "written with 1 and reads back {}. Is its emergency stop pressed, or its enable "
                   "input open? Else check the register map against the drive's manual.",
                   status, map_.enabled_bit, map_.enable_address, back),
       {.action = "enable", .address = map_.status_address});
}

AxisState StepperAxis::Read() {
  AxisState state;
  const std::uint16_t status = ReadWord(map_.status_address, "status");
  state.enabled = config::IsBitSet(status, map_.enabled_bit);
  state.moving = config::IsBitSet(status, map_.running_bit);
  state.fault = config::IsBitSet(status, map_.fault_bit);

  std::array<std::uint16_t, 2> words = {};
  const Timing timing = bus_.ReadHolding(unit_, map_.position_address, words, "command position");
  const std::uint32_t position = config::FromWords(words[0], words[1], map_.word_order);
  position_pulses_ = position_known_
                         ? position_pulses_ + config::WrappedStep32(position_word_, position)
                         : static_cast<std::int32_t>(position);
  position_word_ = position;
  position_known_ = true;
  state.utime = timing.utime_latched;
  state.commanded_deg = static_cast<double>(position_pulses_) / Pulses(config_, 1.0);
  if (state.fault) state.alarm = ReadWord(map_.alarm_address, "alarm");
  ReadInputs(&state);
  return state;
}

// A shaft that turns against the table turns it away from its limit + towards -.
void StepperAxis::ReadInputs(AxisState* state) {
  if (!map_.inputs) return;
  const config::DriveInputs& inputs = *map_.inputs;
  const std::uint16_t word = ReadWord(inputs.address, "inputs");
  const auto acts = [&](const std::optional<int>& bit) {
    return bit && config::IsBitSet(word, *bit) == (inputs.active_level == 1);
  };
  state->emergency_stop = acts(inputs.emergency_stop_bit);
  state->limit_plus = acts(inputs.limit_plus_bit);
  state->limit_minus = acts(inputs.limit_minus_bit);
  if (config_.drive.sign * config_.gear_ratio < 0.0)
    std::swap(state->limit_plus, state->limit_minus);
}

void StepperAxis::CheckReady(const AxisState& state) const {
  if (state.fault) {
    Fail(
        fmt::format(
            "move refused: the drive reports a fault, alarm 0x{:X}. Remove its cause and clear the "
            "alarm.",
            state.alarm),
        {.action = "move", .code_kind = DeviceFailure::CodeKind::kAlarm, .code = state.alarm});
  }
  if (!state.enabled)
    Fail("move refused: the drive is not enabled. Check its enable input and open it again.",
         {.action = "move"});
  if (state.moving)
    Fail("move refused: the drive is still moving. Wait for the move to end, or stop it.",
         {.action = "move"});
}

void StepperAxis::CheckLimits(const AxisState& state, double angle_deg) const {
  if (!(angle_deg > 0.0 ? state.limit_plus : state.limit_minus)) return;
  Fail(
      fmt::format("move by {:g} deg refused: its limit input {} acts. Turn the axis the other way, "
                  "or see to the switch.",
                  angle_deg, angle_deg > 0.0 ? "+" : "-"),
      {.action = "move", .address = map_.inputs->address});
}

double StepperAxis::MoveBy(double angle_deg, double rate_deg_s, double acceleration_deg_s2) {
  const StepperMove move =
      PlanStepperMove(config_, remainder_pulses_, angle_deg, rate_deg_s, acceleration_deg_s2);
  const AxisState state = Read();
  CheckReady(state);
  CheckLimits(state, angle_deg);
  Send(move);
  remainder_pulses_ = move.remainder_pulses;
  return move.rate_deg_s;
}

void StepperAxis::Send(const StepperMove& move) {
  std::array<std::uint16_t, 8> path = {};
  path[0] = map_.relative_mode;
  config::ToWords(static_cast<std::uint32_t>(move.pulses), map_.word_order, path[1], path[2]);
  path[3] = move.rpm;
  path[4] = path[5] = move.ramp_ms_per_1000rpm;
  path[7] = map_.start_value;
  const std::int64_t start_pulses = position_pulses_;
  for (int tries = 1;; ++tries) {
    try {
      bus_.WriteRegisters(unit_, map_.path_address, path, "move", Repeat::kNever);
      return;
    } catch (const RefusedByDevice&) {
      throw;
    } catch (const DeviceError&) {
      const AxisState state = Read();
      if (state.moving || position_pulses_ != start_pulses) return;
      if (tries == kMoveTries || bus_.hurries()) throw;
    }
  }
}

void StepperAxis::Stop() {
  for (int tries = 1;; ++tries) {
    try {
      bus_.WriteRegister(unit_, map_.trigger_address, map_.quick_stop_value, "quick stop");
      return;
    } catch (const DeviceError&) {
      if (tries == kStopTries || bus_.hurries()) throw;
    }
  }
}

void StepperAxis::ClearAlarm() {
  bus_.WriteRegister(unit_, map_.control_address, map_.clear_alarm_value, "clear alarm");
  int alarm = 0;
  for (int reads = 0; reads < kSettleReads; ++reads) {
    alarm = ReadWord(map_.alarm_address, "alarm");
    if (alarm == 0) return;
    if (bus_.hurries()) break;
    bus_.Wait(kSettlePause_us);
  }
  Fail(fmt::format("alarm 0x{:X} stays after it was cleared. Remove its cause (the drive's manual "
                   "lists it).",
                   alarm),
       {.action = "clear alarm", .code_kind = DeviceFailure::CodeKind::kAlarm, .code = alarm});
}

}  // namespace gyrobench::drivers
