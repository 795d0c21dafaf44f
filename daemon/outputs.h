// Fan and heater at work: switched on the thread of their bus, off whenever nobody watches.
#pragma once

#include <map>
#include <memory>
#include <mutex>
#include <string>
#include <vector>

#include "config/stand_config.h"
#include "daemon/bus_worker.h"
#include "daemon/polled_device.h"
#include "drivers/relays.h"

namespace gyrobench::daemon {

// The arguments must outlive it. Any thread may call, but for Open and Check, which belong to the
// bus's.
class Outputs {
 public:
  // `relays` are on the bus of `worker`.
  Outputs(const config::RelaysConfig& config, BusWorker& worker,
          std::unique_ptr<drivers::Relays> relays, FaultHandler on_fault);

  void Open();
  void Check();
  // Which are there, and which are on, as they were switched.
  std::map<std::string, bool> States() const;
  // Waits as `caller`. Throws DeviceError, and LimitError for an output that is not there.
  void Switch(Clock::Participant& caller, const std::string& output, bool on);
  // All that is on; waits as `caller`. The first failure is thrown after all were tried.
  void AllOff(Clock::Participant& caller);
  // What the gyro's thermometer says now. Too hot with the heater on: everything is switched off
  // and a fault reported.
  void Watch(double temperature_degC);

 private:
  void SwitchHere(const std::string& output, bool on);
  void Note(const std::string& output, bool on);

  const config::RelaysConfig& config_;
  BusWorker& worker_;
  const FaultHandler on_fault_;
  const std::unique_ptr<drivers::Relays> relays_;
  mutable std::mutex mutex_;
  std::map<std::string, bool> on_;
  bool too_hot_ = false;
};

}  // namespace gyrobench::daemon
