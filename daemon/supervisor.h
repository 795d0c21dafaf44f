// What becomes of a fault, and of a device that falls silent.
#pragma once

#include <functional>
#include <mutex>
#include <utility>

#include "base/clock.h"
#include "config/stand_config.h"
#include "daemon/acquisition.h"
#include "daemon/fault.h"
#include "daemon/run_control.h"
#include "daemon/telemetry.h"

namespace gyrobench::daemon {

// Latches faults and publishes them (_FAULT): each that is latched once, and once that it is over.
// Thread-safe.
class Supervisor {
 public:
  struct Context {
    const config::StandConfig& stand;
    Clock& clock;
    RunControl& control;
    Telemetry& telemetry;
    std::function<void()> on_change;  // of the state
  };
  explicit Supervisor(Context context) : context_(std::move(context)) {}
  // What it stops and switches off. Before any device is asked; outlives the last report.
  void Watch(Acquisition& acquisition) { acquisition_ = &acquisition; }

  // The first fault is the one that counts; those that follow are in the log.
  void Report(const Fault& fault);
  // Between runs a silent device is a line in the status, not a fault to be cleared by hand. In a run
  // all axes are stopped and all outputs switched off at once, whatever comes of it: without its
  // devices nobody sees what turns and heats. The run waits for one that may come back as it was,
  // but for no relays: a heater that nobody can switch off ends it.
  void FellSilent(const Fault& fault);
  // Throws StateError while a run is on.
  void ClearFault();

 private:
  void AnnounceLocked(bool active, const Fault& fault);

  const Context context_;
  Acquisition* acquisition_ = nullptr;
  // Held from the state's change to its message, so that they come in one order.
  std::mutex mutex_;
  bool announced_ = false;  // the latched fault was published
};

}  // namespace gyrobench::daemon
