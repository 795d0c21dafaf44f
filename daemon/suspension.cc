#include "daemon/suspension.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "base/error.h"
#include "procedures/engine/motion_time.h"

namespace gyrobench::daemon {
namespace {

constexpr double kPoll_s = 0.1;
// After all are back: so that drive and reference have been read, and the table has swung out.
constexpr double kSettle_s = 1.5;
// The way back is in no hurry.
constexpr double kBackRate_deg_s = 10.0;
constexpr double kBackAcceleration_deg_s2 = 50.0;
// Less is not moved back: below what a reference tells and a procedure can mean.
constexpr double kThere_deg = 0.01;

const config::AxisConfig& ConfigOfAxis(const config::StandConfig& stand, const std::string& name) {
  return *std::ranges::find(stand.axes, name, &config::AxisConfig::name);
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

void Suspension::WaitUntilReady(Utime deadline, const Fault& silent) {
  bool stopped = StopAll();
  while (!IsReady() || !stopped) {
    RequireTime(deadline, silent);
    Pass(kPoll_s);
    if (!stopped) stopped = StopAll();
  }
  Pass(kSettle_s);
}

void Suspension::RequireTime(Utime deadline, const Fault& silent) const {
  if (context_.clock.Now() <= deadline) return;
  Fault fault = silent;
  fault.message += fmt::format(
      " The run was suspended, and it did not come back within {:g} s (safety.resume_within_s)",
      context_.stand.safety.resume_within_s);
  throw FaultError(std::move(fault));
}

void Suspension::WaitAndGoBack(const Point& point, const Fault& silent) {
  context_.control.BeginHold();
  const Utime deadline = context_.clock.Now() + FromSeconds(context_.stand.safety.resume_within_s);
  for (;;) {
    WaitUntilReady(deadline, silent);
    try {
      RequireSame(point);
      for (const auto& [axis, was] : point.axes) GoBack(axis, was.drive.commanded_deg);
      Pass(kSettle_s);
      RequireSame(point);
      break;
    } catch (const DeviceError&) {  // silent once more
      RequireTime(deadline, silent);
    }
  }
  context_.control.EndHold();
}

void Suspension::RequireSame(const Point& point) const {
  const auto fail = [](const std::string& source, const std::string& why) {
    throw FaultError({source,
                      fmt::format("{} is back after it fell silent, and the run does not go on: {}",
                                  source, why),
                      {.device = source, .action = "resume"}});
  };
  const SensorView sensor = context_.acquisition.Sensor();
  if (sensor.identity.serial_number != point.serial_number) {
    fail("gyro", fmt::format("it has the serial number {}, expected {}",
                             sensor.identity.serial_number, point.serial_number));
  }
  if (sensor.starts != point.starts) {
    fail("gyro", "it was switched off and on, and its zero-rate offset is another one since");
  }
  for (const auto& [axis, was] : point.axes) {
    if (context_.acquisition.PowerLosses(axis) != point.power_losses.at(axis)) {
      fail("axis." + axis, "its drive had lost its power, or its emergency stop was pressed");
    }
    const AxisView now = context_.acquisition.ReadNow(context_.participant, axis);
    const double drive_deg = now.drive.commanded_deg - was.drive.commanded_deg;
    const double table_deg = now.reference.angle_deg - was.reference.angle_deg;
    const double allowed_deg = ConfigOfAxis(context_.stand, axis).following_error_deg;
    if (std::abs(table_deg - drive_deg) <= allowed_deg) continue;
    fail("axis." + axis,
         fmt::format("its reference moved {:.3f} deg since the command under way began, its drive "
                     "{:.3f} deg, allowed difference {:g} deg (lost steps, or somebody turned it)",
                     table_deg, drive_deg, allowed_deg));
  }
}

void Suspension::GoBack(const std::string& axis, double to_deg) {
  const double now_deg =
      context_.acquisition.ReadNow(context_.participant, axis).drive.commanded_deg;
  const double angle_deg = to_deg - now_deg;
  if (std::abs(angle_deg) < kThere_deg) return;
  const config::AxisConfig& config = ConfigOfAxis(context_.stand, axis);
  const double acceleration_deg_s2 =
      std::min(kBackAcceleration_deg_s2, config.max_acceleration_deg_s2);
  const double rate_deg_s = context_.acquisition.MoveBy(
      context_.participant, axis, angle_deg, std::min(kBackRate_deg_s, config.max_rate_deg_s),
      acceleration_deg_s2, [this] { context_.control.ThrowIfToEnd(); });
  Pass(procedures::MoveDuration_s(angle_deg, rate_deg_s, acceleration_deg_s2));
  while (context_.acquisition.ReadNow(context_.participant, axis).drive.moving) Pass(kPoll_s);
}

void Suspension::GoTo(const std::map<std::string, double>& angles_deg) {
  for (const auto& [axis, to_deg] : angles_deg) {
    const AxisView now = context_.acquisition.ReadNow(context_.participant, axis);
    GoBack(axis, now.drive.commanded_deg + to_deg - now.reference.angle_deg);
  }
  Pass(kSettle_s);
  for (const auto& [axis, to_deg] : angles_deg) {
    const double is_deg =
        context_.acquisition.ReadNow(context_.participant, axis).reference.angle_deg;
    const double allowed_deg = ConfigOfAxis(context_.stand, axis).following_error_deg;
    if (std::abs(is_deg - to_deg) <= allowed_deg) continue;
    throw FaultError({"axis." + axis,
                      fmt::format("its reference shows {:.3f} deg after it was turned to {:.3f} "
                                  "deg, allowed difference {:g} deg",
                                  is_deg, to_deg, allowed_deg),
                      {.device = "axis." + axis, .action = "resume"}});
  }
}

}  // namespace gyrobench::daemon
