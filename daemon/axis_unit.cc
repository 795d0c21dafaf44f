#include "daemon/axis_unit.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "daemon/polled_device.h"

namespace gyrobench::daemon {
namespace {

// Beyond a soft limit by more than the play of a worm and the noise of an encoder.
constexpr double kSoftLimitMargin_deg = 0.2;
// A reference may be so much older than the drive's word, beside the delay that its map declares:
// one that nobody declared is a finding of the analysis, not a fault.
constexpr double kReferenceAge_s = 0.5;
constexpr int kReadingsBeyond = 2;

}  // namespace

std::int8_t AxisNumber(const std::string& name) {
  if (name == "outer") return angle_t::OUTER;
  return name == "middle" ? angle_t::MIDDLE : angle_t::INNER;
}

AxisUnit::AxisUnit(const config::AxisConfig& config, BusWorker& drive_bus, BusWorker& encoder_bus,
                   drivers::DeviceMaker& devices, Telemetry& telemetry, Hooks hooks)
    : config_(config),
      drive_bus_(drive_bus),
      encoder_bus_(encoder_bus),
      telemetry_(telemetry),
      hooks_(std::move(hooks)),
      drive_(devices.MakeAxis(config)),
      encoder_(devices.MakeAngleSensor(config)),
      last_(kLastSamples) {}

Utime AxisUnit::encoder_period() const {
  return FromSeconds(1.0 / (active_ ? config_.encoder.rate_hz : config_.encoder.idle_rate_hz));
}

AxisView AxisUnit::view() const {
  const std::lock_guard lock(mutex_);
  return view_;
}

LastSamples::Axis AxisUnit::last() const {
  const std::lock_guard lock(mutex_);
  return {config_.name, view_.drive, {last_.begin(), last_.end()}};
}

void AxisUnit::StopIfMoving() {
  if (!drive_->IsMoving()) return;
  try {
    drive_->Stop();
  } catch (const std::exception& error) {
    hooks_.on_found_moving(error.what());
    throw;
  }
  hooks_.on_found_moving("");
}

void AxisUnit::OpenDrive() {
  drive_answers_ = false;
  StopIfMoving();
  const drivers::AxisState found = drive_->Open();
  drive_answers_ = true;
  {
    const std::lock_guard lock(mutex_);
    view_.drive = found;
  }
}

void AxisUnit::OpenEncoder() {
  const drivers::AngleReading first = encoder_->Open();
  const std::lock_guard lock(mutex_);
  view_.reference = first;
}

void AxisUnit::ReadEncoder() {
  const drivers::AngleReading reading = encoder_->Read();
  {
    const std::lock_guard lock(mutex_);
    view_.reference = reading;
    last_.push_back(reading);
  }
  message_.utime = reading.utime;
  message_.axis = AxisNumber(config_.name);
  message_.counts = reading.counts;
  message_.angle_deg = reading.angle_deg;
  message_.utime_request = reading.utime_request;
  message_.utime_reply = reading.utime_reply;
  telemetry_.Send(message_);
  CheckSoftLimits(reading.angle_deg);
}

void AxisUnit::CheckSoftLimits(double angle_deg) {
  if (!active_) return;
  if (angle_deg >= config_.min_deg - kSoftLimitMargin_deg &&
      angle_deg <= config_.max_deg + kSoftLimitMargin_deg) {
    beyond_limit_ = false;
    return;
  }
  if (std::exchange(beyond_limit_, true)) return;
  hooks_.stop_all();
  hooks_.on_fault(
      {"axis." + config_.name,
       fmt::format("the table is at {:.3f} deg, beyond its soft limits {:g} .. {:g} deg: stopped. "
                   "Turn it back by hand or correct the limits, then: gyrobench reset",
                   angle_deg, config_.min_deg, config_.max_deg),
       {.device = "axis." + config_.name, .action = "soft limits"}});
}

// A reference shows the table as it was `age` ago, so a move by r deg/s seems to lag by r * age. In a
// reversal, and wherever the axis was moving within that time, so does the reading that the move is
// counted from, by the rate of the move before, and the other way.
double AxisUnit::MoveBy(double angle_deg, double rate_deg_s, double acceleration_deg_s2) {
  const AxisView begin = view();
  const double rate = drive_->MoveBy(angle_deg, rate_deg_s, acceleration_deg_s2);
  const double age_s = kReferenceAge_s + config_.encoder.map.delay_s;
  const bool moved_before =
      move_ || (last_rate_deg_s_ > 0 && begin.drive.utime - at_rest_since_ < FromSeconds(age_s));
  const double before_deg_s = moved_before ? (move_ ? move_->rate_deg_s : last_rate_deg_s_) : 0.0;
  move_ = Move{begin,
               rate,
               config_.following_error_deg + (rate + before_deg_s) * age_s,
               begin.drive,
               begin.reference.utime,
               0};
  return rate;
}

void AxisUnit::CheckFollowing(const drivers::AxisState& state) {
  if (!move_) return;
  if (!state.moving) {
    last_rate_deg_s_ = move_->rate_deg_s;
    at_rest_since_ = state.utime;
    move_.reset();
    return;
  }
  const drivers::AxisState before = std::exchange(move_->polled, state);
  const drivers::AngleReading reference = view().reference;
  // Each reading once, as late as it comes: one that is silent is told as such.
  if (reference.utime <= move_->judged) return;
  move_->judged = reference.utime;
  const double share = state.utime > before.utime
                           ? static_cast<double>(reference.utime - before.utime) /
                                 static_cast<double>(state.utime - before.utime)
                           : 1.0;
  const double drive_deg =
      std::lerp(before.commanded_deg, state.commanded_deg, std::clamp(share, 0.0, 1.0));
  const double commanded_deg = drive_deg - move_->begin.drive.commanded_deg;
  const double moved_deg = reference.angle_deg - move_->begin.reference.angle_deg;
  const bool follows = std::abs(moved_deg - commanded_deg) <= move_->allowed_deg;
  move_->beyond = follows ? 0 : move_->beyond + 1;
  if (move_->beyond == kReadingsBeyond) FailFollowing(moved_deg, commanded_deg);
}

void AxisUnit::FailFollowing(double moved_deg, double commanded_deg) {
  const double allowed_deg = move_->allowed_deg;
  move_.reset();
  hooks_.stop_all();
  hooks_.on_fault(
      {"axis." + config_.name,
       fmt::format(
           "the table does not follow its drive: in the move under way the reference sensor "
           "moved {:.3f} deg, the drive {:.3f} deg, allowed difference {:.3g} deg: stopped "
           "(lost steps, a loose coupling, a reference that is frozen, or a wrong gear ratio "
           "or encoder resolution in the stand file?)",
           moved_deg, commanded_deg, allowed_deg),
       {.device = "axis." + config_.name, .action = "move"}});
}

drivers::AxisState AxisUnit::AskDrive() {
  drive_answers_ = false;
  const drivers::AxisState state = drive_->Read();
  drive_answers_ = true;
  return state;
}

void AxisUnit::ReadDrive() {
  const drivers::AxisState state = AskDrive();
  {
    const std::lock_guard lock(mutex_);
    view_.drive = state;
  }
  hooks_.on_drive_read(state.utime);
  CheckFollowing(state);
  if (!state.fault && !state.enabled) {
    throw MustBeOpenedAgain(
        fmt::format("axis.{}: the drive is no longer enabled. Did it lose its power, or was its "
                    "emergency stop pressed? It is enabled again when it can be",
                    config_.name),
        {.device = "axis." + config_.name + " drive", .action = "status"});
  }
  if (!state.fault) return;
  hooks_.on_fault(
      {"axis." + config_.name,
       fmt::format("the drive reports alarm {} (0x{:02X}). See the drive's manual, remove the "
                   "cause, then: gyrobench reset",
                   state.alarm, state.alarm),
       {.device = "axis." + config_.name + " drive",
        .action = "status",
        .code_kind = DeviceFailure::CodeKind::kAlarm,
        .code = state.alarm}});
}

}  // namespace gyrobench::daemon
