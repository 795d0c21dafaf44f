#include "daemon/axis_unit.h"

#include <fmt/format.h>

#include <utility>

#include "daemon/polled_device.h"

namespace gyrobench::daemon {
namespace {

// Beyond a soft limit by more than the play of a worm and the noise of an encoder.
constexpr double kSoftLimitMargin_deg = 0.2;

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
      guard_(config),
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
  guard_.MayMove();
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
  if (!found.enabled) ++power_losses_;
  guard_.DriveOpened();
  drive_answers_ = true;
  {
    const std::lock_guard lock(mutex_);
    view_.drive = found;
  }
}

void AxisUnit::OpenEncoder() {
  const drivers::AngleReading first = encoder_->Open();
  guard_.ReferenceOpened();
  const std::lock_guard lock(mutex_);
  view_.reference = first;
}

void AxisUnit::MayHaveBeenTurned() {
  guard_.MayMove();
  guard_.ReferenceOpened();
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
  Trip(guard_.Read(reading));
}

void AxisUnit::CheckSoftLimits(double angle_deg) {
  if (!active_) return;
  if (angle_deg >= config_.min_deg - kSoftLimitMargin_deg &&
      angle_deg <= config_.max_deg + kSoftLimitMargin_deg) {
    beyond_limit_ = false;
    return;
  }
  if (beyond_limit_.exchange(true)) return;
  hooks_.stop_all();
  hooks_.on_fault(
      {"axis." + config_.name,
       fmt::format("the table is at {:.3f} deg, beyond its soft limits {:g} .. {:g} deg: stopped. "
                   "Turn it back by hand or correct the limits, then: gyrobench reset",
                   angle_deg, config_.min_deg, config_.max_deg),
       {.device = "axis." + config_.name, .action = "soft limits"}});
}

double AxisUnit::MoveBy(double angle_deg, double rate_deg_s, double acceleration_deg_s2) {
  const AxisView begin = view();
  guard_.MayMove();  // also where the drive's answer is lost
  const double rate = drive_->MoveBy(angle_deg, rate_deg_s, acceleration_deg_s2);
  guard_.Begin(begin, angle_deg, rate, acceleration_deg_s2);
  return rate;
}

void AxisUnit::Trip(const std::optional<Fault>& fault) {
  if (!fault) return;
  hooks_.stop_all();
  hooks_.on_fault(*fault);
}

// Its drive has stopped the axis by itself then; the others have not. From a limit that acts the
// axis may be turned away, once the fault is reset.
void AxisUnit::CheckInputs(const drivers::AxisState& state) {
  const bool at_limit = state.limit_plus || state.limit_minus;
  const bool new_at_limit = at_limit && !at_limit_;
  at_limit_ = at_limit;
  if (!state.emergency_stop) emergency_stop_told_ = false;
  std::string says;
  if (state.emergency_stop && !emergency_stop_told_.exchange(true)) {
    says =
        "the emergency stop input of its drive acts: all axes are stopped. Release it once nothing "
        "is in the way, then: gyrobench reset";
  } else if (new_at_limit) {
    says = fmt::format(
        "the limit input {} of its drive acts, with the table at {:.3f} deg: all axes are stopped. "
        "After gyrobench reset the axis can be turned the other way",
        state.limit_plus ? "+" : "-", view().reference.angle_deg);
  }
  if (says.empty()) return;
  Trip(Fault{"axis." + config_.name,
             says,
             {.device = "axis." + config_.name + " drive", .action = "inputs"}});
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
  CheckInputs(state);
  Trip(guard_.Polled(state, view().reference));
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
