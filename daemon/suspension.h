// A run that waits for a device that fell silent, and goes on from where its last command began.
#pragma once

#include <cstdint>
#include <map>
#include <string>

#include "base/clock.h"
#include "config/stand_config.h"
#include "daemon/acquisition.h"
#include "daemon/run_control.h"
#include "daemon/telemetry.h"

namespace gyrobench::daemon {

// In the run's thread.
class Suspension {
 public:
  struct Context {
    const config::StandConfig& stand;
    Clock& clock;
    Clock::Participant& participant;
    Acquisition& acquisition;
    RunControl& control;
  };
  // What a command begins from: where the axes are, and which devices they are.
  struct Point {
    std::map<std::string, AxisView> axes;
    std::map<std::string, int> power_losses;
    std::uint32_t serial_number = 0;
    int starts = 0;  // of the gyro unit
  };
  explicit Suspension(const Context& context) : context_(context) {}

  Point Here() const;
  // Stops all axes, waits until all devices are well and the axes at rest, makes sure that they are
  // the same and that no steps were lost, and turns the axes back to `point`. Throws FaultError where
  // that takes longer than safety.resume_within_s or something is not as it was, and
  // procedures::Aborted.
  void WaitAndGoBack(const Point& point, const Fault& silent);
  // Turns the axes, of which nothing is known but what their references show, to these angles.
  // Throws as a move does, and FaultError where an axis is not there then.
  void GoTo(const std::map<std::string, double>& angles_deg);

 private:
  bool StopAll() const;
  bool IsReady() const;
  void RequireSame(const Point& point) const;
  void WaitUntilReady(Utime deadline, const Fault& silent);
  void RequireTime(Utime deadline, const Fault& silent) const;
  // By the drive's own count.
  void GoBack(const std::string& axis, double to_deg);
  void Pass(double duration_s);

  const Context context_;
};

}  // namespace gyrobench::daemon
