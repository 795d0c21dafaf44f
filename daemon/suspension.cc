#include "daemon/suspension.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "base/error.h"
#include "daemon/bench_facts.h"
#include "daemon/polled_device.h"
#include "procedures/engine/motion_time.h"

namespace gyrobench::daemon {
namespace {

constexpr double kPoll_s = 0.1;
constexpr double kPausePoll_s = 1.0;
// After all are back: so that drive and reference have been read, and the table has swung out.
constexpr double kSettle_s = 1.5;
// The way back is in no hurry.
constexpr double kBackRate_deg_s = 10.0;
constexpr double kBackAcceleration_deg_s2 = 50.0;
// In one hold; more is a device that does not stay.
constexpr int kMostRounds = 4;
constexpr const char* kWhat = "a device's silence";
// Less is not moved back: below what a reference tells and a procedure can mean.
constexpr double kThere_deg = 0.01;

// Nor is what a drive cannot do: it goes by whole pulses.
double There_deg(const config::AxisConfig& axis) {
  const double pulse_deg = 360.0 / std::abs(axis.gear_ratio * axis.drive.map.pulses_per_turn);
  return std::max(kThere_deg, 1.01 * pulse_deg);
}

}  // namespace

Suspension::Point Suspension::Here() const {
  Point point;
  for (const config::AxisConfig& axis : context_.stand.axes) {
    point.axes[axis.name] = context_.acquisition.Axis(axis.name);
    point.power_losses[axis.name] = context_.acquisition.PowerLosses(axis.name);
  }
  const SensorView sensor = context_.acquisition.Sensor();
  point.serial_number = sensor.identity.serial_number;
  point.starts = sensor.starts;
  return point;
}

void Suspension::Pass(double duration_s) {
  context_.control.Wait(context_.clock, context_.clock.Now() + FromSeconds(duration_s));
}

// A drive that does not answer cannot be told; it is when it does (AxisUnit::OpenDrive).
bool Suspension::StopAll() const {
  try {
    context_.acquisition.StopAll(context_.participant);
    return true;
  } catch (const DeviceError&) {
    return false;
  }
}

bool Suspension::IsReady() const {
  return std::ranges::all_of(context_.acquisition.Devices(), &DeviceStatus::ok) &&
         std::ranges::none_of(context_.stand.axes, [this](const config::AxisConfig& axis) {
           return context_.acquisition.Axis(axis.name).drive.moving;
         });
}

Fault Suspension::NotWell(const Fault& silent) const {
  for (const DeviceStatus& device : context_.acquisition.Devices())
    if (!device.ok) return {device.name, device.message, device.failure};
  return silent;
}

int Suspension::WaitUntilReady(const Fault& silent) {
  const Utime deadline = context_.clock.Now() + FromSeconds(context_.stand.safety.resume_within_s);
  if (Outputs* outputs = context_.acquisition.outputs()) outputs->PostAllOff();
  bool stopped = StopAll();
  for (;;) {
    // Counted before it is looked at, so that what is told later is missed by who goes on.
    const int silences = context_.control.silences();
    if (stopped && IsReady()) {
      Pass(kSettle_s);
      return silences;
    }
    RequireTime(deadline, silent, "suspended");
    Pass(kPoll_s);
    if (!stopped) stopped = StopAll();
  }
}

void Suspension::RequireTime(Utime deadline, const Fault& silent, const char* what) const {
  // A device that came back in time is found by the next try to open it.
  if (context_.clock.Now() <= deadline + kFoundWithin) return;
  Fault fault = NotWell(silent);
  fault.message += fmt::format(
      " The run was {}, and it did not come back within {:g} s (safety.resume_within_s)", what,
      context_.stand.safety.resume_within_s);
  throw FaultError(std::move(fault));
}

Utime Suspension::LookInPause(std::optional<Utime>& since) const {
  const Utime now = context_.clock.Now();
  const Fault silent = NotWell({});
  if (silent.source.empty()) {
    since.reset();
    return kForever;
  }
  if (!since) since = now;
  RequireTime(*since + FromSeconds(context_.stand.safety.resume_within_s), silent, "paused");
  return now + FromSeconds(kPausePoll_s);
}

void Suspension::RequireNoMore(int silences) const {
  context_.control.ThrowIfToEnd();
  if (context_.control.silences() == silences) return;
  throw Suspended(context_.control.suspended().value_or(Fault{}));
}

void Suspension::WaitAndGoBack(const Point& point, const Fault& silent,
                               const std::set<std::string>& on) {
  context_.control.BeginHold();
  Fault waited_for = silent;
  for (int rounds = 1;; ++rounds) {
    const int silences = WaitUntilReady(waited_for);
    const std::optional<Fault> again = GoOn(point, waited_for, silences, on);
    if (!again) return;
    context_.control.ThrowIfToEnd();
    waited_for = *again;
    if (rounds < kMostRounds) continue;
    waited_for.message += fmt::format(
        " The run was suspended, and {} times a device fell silent before it could go on",
        kMostRounds);
    throw FaultError(std::move(waited_for));
  }
}

std::optional<Fault> Suspension::GoOn(const Point& point, const Fault& silent, int silences,
                                      const std::set<std::string>& on) {
  try {
    RequireSame(point, kWhat);
    for (const auto& [axis, was] : point.axes) GoBack(axis, was.drive.commanded_deg, silences);
    Pass(kSettle_s);
    RequireSame(point, kWhat);
    for (const std::string& output : on) {
      context_.acquisition.outputs()->Switch(context_.participant, output, true,
                                             [&] { RequireNoMore(silences); });
    }
    if (IsReady() && context_.control.EndHold(silences)) return std::nullopt;
    return NotWell(silent);
  } catch (const Suspended& again) {
    return again.fault();
  } catch (const DeviceError& error) {
    return FaultOfDevice(error);
  }
}

void Suspension::RequireSame(const Point& point, const std::string& what) const {
  const auto fail = [&what](const std::string& source, const std::string& why) {
    throw FaultError({source,
                      fmt::format("after {} the run does not go on: {}", what, why),
                      {.device = source, .action = "resume"}});
  };
  const SensorView sensor = context_.acquisition.Sensor();
  if (sensor.identity.serial_number != point.serial_number) {
    fail("gyro", fmt::format("it has the serial number {}, expected {}",
                             sensor.identity.serial_number, point.serial_number));
  }
  if (point.starts && sensor.starts != *point.starts) {
    fail("gyro", "it was switched off and on, and its zero-rate offset is another one since");
  }
  for (const auto& [axis, was] : point.axes) {
    if (context_.acquisition.PowerLosses(axis) != point.power_losses.at(axis)) {
      fail("axis." + axis, "its drive had lost its power, or its emergency stop was pressed");
    }
    const AxisView now = context_.acquisition.ReadNow(context_.participant, axis);
    const double drive_deg = now.drive.commanded_deg - was.drive.commanded_deg;
    const double table_deg = now.reference.angle_deg - was.reference.angle_deg;
    const double allowed_deg = ConfigOf(context_.stand, axis).following_error_deg;
    if (std::abs(table_deg - drive_deg) <= allowed_deg) continue;
    fail("axis." + axis,
         fmt::format("its reference moved {:.3f} deg since the command under way began, its drive "
                     "{:.3f} deg, allowed difference {:g} deg (lost steps, or somebody turned it)",
                     table_deg, drive_deg, allowed_deg));
  }
}

void Suspension::GoBack(const std::string& axis, double to_deg, int silences) {
  const double now_deg =
      context_.acquisition.ReadNow(context_.participant, axis).drive.commanded_deg;
  const double angle_deg = to_deg - now_deg;
  const config::AxisConfig& config = ConfigOf(context_.stand, axis);
  if (std::abs(angle_deg) < There_deg(config)) return;
  const double acceleration_deg_s2 =
      std::min(kBackAcceleration_deg_s2, config.max_acceleration_deg_s2);
  const double rate_deg_s = context_.acquisition.MoveBy(
      context_.participant, axis, angle_deg, std::min(kBackRate_deg_s, config.max_rate_deg_s),
      acceleration_deg_s2, [&] { RequireNoMore(silences); });
  const double duration_s = procedures::MoveDuration_s(angle_deg, rate_deg_s, acceleration_deg_s2);
  const Utime end = context_.clock.Now() + FromSeconds(duration_s);
  const auto moves = [&] {
    return context_.clock.Now() < end ||
           context_.acquisition.ReadNow(context_.participant, axis).drive.moving;
  };
  while (moves()) {
    Pass(kPoll_s);
    RequireNoMore(silences);
  }
  // Somebody may have stopped it on its way.
  const double left_deg = to_deg - context_.acquisition.Axis(axis).drive.commanded_deg;
  if (std::abs(left_deg) < There_deg(config)) return;
  throw DeviceError(fmt::format("axis.{}: on the way back to where the command under way began it "
                                "came to rest {:.3f} deg before it",
                                axis, left_deg),
                    {.device = "axis." + axis, .action = "go back"});
}

void Suspension::GoTo(const std::map<std::string, double>& angles_deg) {
  for (const auto& [axis, to_deg] : angles_deg) {
    const AxisView now = context_.acquisition.ReadNow(context_.participant, axis);
    GoBack(axis, now.drive.commanded_deg + to_deg - now.reference.angle_deg,
           context_.control.silences());
  }
  Pass(kSettle_s);
  for (const auto& [axis, to_deg] : angles_deg) {
    const double is_deg =
        context_.acquisition.ReadNow(context_.participant, axis).reference.angle_deg;
    const double allowed_deg = ConfigOf(context_.stand, axis).following_error_deg;
    if (std::abs(is_deg - to_deg) <= allowed_deg) continue;
    throw FaultError({"axis." + axis,
                      fmt::format("its reference shows {:.3f} deg after it was turned to {:.3f} "
                                  "deg, allowed difference {:g} deg",
                                  is_deg, to_deg, allowed_deg),
                      {.device = "axis." + axis, .action = "resume"}});
  }
}

}  // namespace gyrobench::daemon
