#include "stand/devices/drive_device.h"

#include <algorithm>
#include <cmath>

namespace gyrobench::stand {
namespace {

enum PathWord : std::size_t { kMode, kFirst, kSecond, kRpm, kUp, kDown, kPause, kTrigger };
constexpr std::uint16_t kAbsoluteMode = 0x0001;
constexpr std::uint16_t kRunPath0 = 0x0010;
constexpr std::uint16_t kRunning = 0x0100;  // the trigger register while path 0 runs

}  // namespace

DriveDevice::DriveDevice(std::string name, const config::DriveMap& map, std::size_t axis,
                         Physics& physics)
    : Device(std::move(name)),
      map_(map),
      axis_(axis),
      physics_(physics),
      pulses_per_turn_(map.pulses_per_turn),
      saved_pulses_per_turn_(map.pulses_per_turn) {}

// kPathWords when the address is not in the path.
std::size_t DriveDevice::PathIndex(std::uint16_t address) const {
  return std::min<std::size_t>(static_cast<std::uint16_t>(address - map_.path_address), kPathWords);
}

std::uint16_t DriveDevice::Status(const Physics::DriveView& view) const {
  const auto bit = [](int position, bool on) { return on ? 1 << position : 0; };
  const bool done = !view.moving;
  return static_cast<std::uint16_t>(
      bit(map_.fault_bit, view.alarm != 0) | bit(map_.enabled_bit, enabled_) |
      bit(map_.running_bit, view.moving) | bit(map_.command_done_bit, done) |
      bit(map_.path_done_bit, done));
}

std::uint16_t DriveDevice::Inputs(const Physics::DriveView& view) const {
  std::uint16_t active = 0;
  const auto set = [&active](const std::optional<int>& bit, bool acts) {
    if (bit && acts) active = static_cast<std::uint16_t>(active | 1U << *bit);
  };
  set(map_.inputs->emergency_stop_bit, view.emergency_stop);
  set(map_.inputs->limit_plus_bit, view.limit_plus);
  set(map_.inputs->limit_minus_bit, view.limit_minus);
  return map_.inputs->active_level == 1 ? active : static_cast<std::uint16_t>(~active);
}

std::optional<std::uint16_t> DriveDevice::Register(std::uint16_t address,
                                                   const Physics::DriveView& view) const {
  if (address == map_.status_address) return Status(view);
  if (map_.inputs && address == map_.inputs->address) return Inputs(view);
  const double commanded = std::round(static_cast<double>(view.pulses) / PulsesOfOne());
  const auto position = static_cast<std::uint32_t>(static_cast<std::int32_t>(commanded));
  const bool high_first = map_.word_order == config::WordOrder::kHighFirst;
  if (address == map_.position_address) return high_first ? High(position) : Low(position);
  if (address == map_.position_address + 1) return high_first ? Low(position) : High(position);
  if (address == map_.pulses_per_turn_address) return static_cast<std::uint16_t>(pulses_per_turn_);
  if (address == map_.enable_address) return static_cast<std::uint16_t>(enabled_ ? 1 : 0);
  if (address == map_.alarm_address) return static_cast<std::uint16_t>(view.alarm);
  if (address == map_.control_address) return std::uint16_t{0};
  if (address == map_.trigger_address) return view.moving ? kRunning : std::uint16_t{0};
  if (const std::size_t i = PathIndex(address); i < kPathWords) return path_[i];
  return std::nullopt;
}

ModbusException DriveDevice::Read(int function, std::uint16_t address,
                                  std::span<std::uint16_t> words, Utime at) {
  if (function != 3) return ModbusException::kIllegalFunction;
  const Physics::DriveView view = physics_.Drive(axis_, at);
  if (view.emergency_stop) enabled_ = false;
  for (std::size_t i = 0; i < words.size(); ++i) {
    const auto value = Register(static_cast<std::uint16_t>(address + i), view);
    if (!value) return ModbusException::kIllegalAddress;
    words[i] = *value;
  }
  return ModbusException::kNone;
}

bool DriveDevice::IsWritable(std::uint16_t address) const {
  return address == map_.enable_address || address == map_.control_address ||
         address == map_.trigger_address || address == map_.pulses_per_turn_address ||
         PathIndex(address) < kPathWords;
}

ModbusException DriveDevice::Write(std::uint16_t address, std::span<const std::uint16_t> words,
                                   Utime at) {
  // All or nothing.
  for (std::size_t i = 0; i < words.size(); ++i) {
    if (!IsWritable(static_cast<std::uint16_t>(address + i)))
      return ModbusException::kIllegalAddress;
  }
  for (std::size_t i = 0; i < words.size(); ++i) {
    const auto failed = WriteOne(static_cast<std::uint16_t>(address + i), words[i], at);
    if (failed != ModbusException::kNone) return failed;
  }
  return ModbusException::kNone;
}

ModbusException DriveDevice::WriteOne(std::uint16_t address, std::uint16_t value, Utime at) {
  if (address == map_.trigger_address) return Trigger(value, at);
  if (address == map_.control_address) {
    if (value == map_.clear_alarm_value) physics_.ClearAlarm(axis_, at);
    if (value == map_.save_value) saved_pulses_per_turn_ = pulses_per_turn_;
    return ModbusException::kNone;
  }
  if (address == map_.pulses_per_turn_address) {
    if (value == 0 || physics_.Drive(axis_, at).moving) return ModbusException::kIllegalValue;
    pulses_per_turn_ = value;
    return ModbusException::kNone;
  }
  if (address == map_.enable_address) {
    enabled_ = value != 0 && !physics_.Drive(axis_, at).emergency_stop;
    if (!enabled_) physics_.QuickStop(axis_, at);
    return ModbusException::kNone;
  }
  const std::size_t i = PathIndex(address);
  path_[i] = value;
  return i == kTrigger && value == map_.start_value ? RunPath(at) : ModbusException::kNone;
}

ModbusException DriveDevice::Trigger(std::uint16_t value, Utime at) {
  if (value == kRunPath0) return RunPath(at);
  if (value != map_.quick_stop_value) return ModbusException::kIllegalValue;
  physics_.QuickStop(axis_, at);
  return ModbusException::kNone;
}

ModbusException DriveDevice::RunPath(Utime at) {
  const auto within = [](int value, int low, int high) { return value >= low && value <= high; };
  const auto ramp_fits = [&](PathWord word) {
    return within(path_[word], map_.min_ramp_ms_per_1000rpm, map_.max_ramp_ms_per_1000rpm);
  };
  const bool relative = path_[kMode] == map_.relative_mode;
  if (!relative && path_[kMode] != kAbsoluteMode) return ModbusException::kIllegalValue;
  if (!within(path_[kRpm], map_.min_rpm, map_.max_rpm) || !ramp_fits(kUp) || !ramp_fits(kDown)) {
    return ModbusException::kIllegalValue;
  }
  if (!enabled_) return ModbusException::kNone;
  const bool high_first = map_.word_order == config::WordOrder::kHighFirst;
  const std::uint32_t high = path_[high_first ? kFirst : kSecond];
  const std::uint32_t low = path_[high_first ? kSecond : kFirst];
  const double commanded = static_cast<double>(static_cast<std::int32_t>(high << 16U | low));
  const std::int64_t position = std::llround(commanded * PulsesOfOne());
  const MoveCommand command{.target = position,
                            .rpm = static_cast<double>(path_[kRpm]),
                            .ramp_up_ms = static_cast<double>(path_[kUp]),
                            .ramp_down_ms = static_cast<double>(path_[kDown])};
  if (relative) {
    physics_.MoveBy(axis_, at, position, command);
  } else {
    physics_.MoveTo(axis_, at, command);
  }
  return ModbusException::kNone;
}

// The physics stops the motor and begins the count anew.
void DriveDevice::LosePower(Utime /*at*/) {
  enabled_ = false;
  path_ = {};
  pulses_per_turn_ = saved_pulses_per_turn_;
}

ModbusException DriveDevice::Disguise(std::uint16_t address, std::span<std::uint16_t> words) {
  const std::size_t i = static_cast<std::uint16_t>(map_.pulses_per_turn_address - address);
  if (i < words.size()) words[i] = static_cast<std::uint16_t>(pulses_per_turn_ / 5 * 2);
  return ModbusException::kNone;
}

}  // namespace gyrobench::stand
