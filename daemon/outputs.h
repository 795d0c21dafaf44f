// Fan and heater at work: switched on the thread of their bus, and off when a run ends.
#pragma once

#include <functional>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <string>

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

  // Both throw DeviceError.
  void Open();
  // What is not as it was switched (the unit was restarted, somebody else switches, an earlier
  // switching off has failed) is switched off and reported as a fault.
  void Check();

  // Which there are, and which are on; nullopt while the unit does not answer.
  std::map<std::string, std::optional<bool>> States() const;
  // Waits as `caller`. `may_switch` is asked in the bus's thread right before, and throws when the
  // run is to end: nothing is switched on after a stop. Where the unit fails, nobody knows whether it
  // is on: all are switched off, and FaultError is thrown, unless the run is to end anyway. Throws
  // LimitError for an output that is not there, and what `may_switch` throws.
  void Switch(Clock::Participant& caller, const std::string& output, bool on,
              const std::function<void()>& may_switch);
  // Does not wait; what fails is a fault.
  void PostAllOff();
  // Waits as `caller`. All are tried, the heater first; then what failed is thrown as one
  // DeviceError. What has failed is tried again at every poll.
  void AllOff(Clock::Participant& caller);
  // What the gyro's thermometer says now. Too hot with the heater on: everything is switched off
  // and a fault reported.
  void Watch(double temperature_degC);

 private:
  // These belong to the thread of the bus.
  void Compare(const std::map<std::string, bool>& found);
  // What went wrong; nullopt if nothing.
  std::optional<Fault> TryAllOff();
  void SwitchHere(const std::string& output, bool on);
  // Tried again: one lost reply leaves nothing on. What is urgent on the line goes between the
  // tries: a relay unit that is silent holds up no stop.
  void SwitchOffHere(const std::string& output);

  const config::RelaysConfig& config_;
  BusWorker& worker_;
  const FaultHandler on_fault_;
  const std::unique_ptr<drivers::Relays> relays_;
  mutable std::mutex mutex_;  // guards what follows
  std::map<std::string, bool> wanted_;
  bool answers_ = false;
  bool too_hot_ = false;  // reported, and the heater is not off yet
};

}  // namespace gyrobench::daemon
