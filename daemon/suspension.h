// A run that waits for a device that fell silent, and goes on from where its last command began.
#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <set>
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
  // Where the axes are, and which devices they are, at a moment at which nothing was silent.
  struct Point {
    std::map<std::string, AxisView> axes;
    std::map<std::string, int> power_losses;
    std::uint32_t serial_number = 0;
    std::optional<int> starts;  // of the gyro unit; nullopt where it may be switched off and on
  };
  explicit Suspension(const Context& context) : context_(context) {}

  Point Here() const;
  // Throws FaultError, "after `what` the run does not go on: ...", where the gyro or a drive is not
  // the same or was switched off since `point`, or a table was turned by other hands than its drive.
  // Throws DeviceError where one does not answer.
  void RequireSame(const Point& point, const std::string& what) const;
  // Stops all axes, switches all outputs off, waits until all devices are well and the axes at rest,
  // makes sure that they are the same and that no steps were lost, turns the axes back to `point`,
  // and switches the outputs of `on` on again. A device that falls silent meanwhile is waited for in
  // its turn. Throws FaultError where one stays silent for longer than safety.resume_within_s, does
  // not stay, or is not as it was, and procedures::Aborted.
  void WaitAndGoBack(const Point& point, const Fault& silent, const std::set<std::string>& on);
  // While nothing is measured: when to look again; kForever where all devices are well, since it is
  // told when one falls silent. `since`: of the silence that is going on, between looks. Throws
  // FaultError where it goes on for longer than safety.resume_within_s.
  Utime LookInPause(std::optional<Utime>& since) const;
  // Turns the axes, of which nothing is known but what their references show, to these angles.
  // Throws as a move does, and FaultError where an axis is not there then.
  void GoTo(const std::map<std::string, double>& angles_deg);

 private:
  bool StopAll() const;
  bool IsReady() const;
  // The device that is not well now; `silent` where all are.
  Fault NotWell(const Fault& silent) const;
  // How many silences there were before all were well.
  int WaitUntilReady(const Fault& silent);
  // `what`: "suspended", "paused".
  void RequireTime(Utime deadline, const Fault& silent, const char* what) const;
  // Throws Suspended where there was another silence.
  void RequireNoMore(int silences) const;
  // From all well to the end of the hold. What fell silent meanwhile; nullopt if nothing did.
  std::optional<Fault> GoOn(const Point& point, const Fault& silent, int silences,
                            const std::set<std::string>& on);
  // By the drive's own count. Throws DeviceError where the axis does not arrive.
  void GoBack(const std::string& axis, double to_deg, int silences);
  void Pass(double duration_s);

  const Context context_;
};

}  // namespace gyrobench::daemon
