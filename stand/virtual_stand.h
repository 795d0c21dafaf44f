// The virtual stand: the physics behind real Modbus.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <string>

#include "base/clock.h"
#include "config/scenario.h"
#include "config/stand_config.h"

namespace gyrobench::stand {

class Device;
class Physics;

// Serves the devices of a stand file. With the system clock it runs in real time; with a virtual
// clock each transaction takes the time that its bytes would take on the wire. Power-on is at
// construction.
class VirtualStand {
 public:
  // Where a TCP bus is served.
  enum class Port {
    kFree,         // any free port of 127.0.0.1
    kAsConfigured  // the stand file's host and port
  };

  // Another gyro unit in place of the stand's own, for its physics and their power-on.
  using MakeGyroUnit = std::function<std::unique_ptr<Device>(Physics&, Utime start)>;

  // `stand` tells devices, maps, site; the specimen is drawn from the scenario with `seed`. Both
  // are copied; the clock must outlive the stand. Throws ConfigError.
  VirtualStand(const config::StandConfig& stand, const config::Scenario& scenario,
               std::uint64_t seed, Clock& clock, MakeGyroUnit make_gyro_unit = {});
  // The seed of the stand file's [virtual] table, 1 without it.
  VirtualStand(const config::StandConfig& stand, const config::Scenario& scenario, Clock& clock);
  // Stops the servers; a client then finds silent lines.
  ~VirtualStand();
  VirtualStand(const VirtualStand&) = delete;
  VirtualStand& operator=(const VirtualStand&) = delete;

  // Starts a thread that serves the devices of this bus. Returns the bus as the driver is to open
  // it: for rtu with the path of a pseudo-terminal, for tcp with host and port. Throws ConfigError
  // for two devices of one unit, DeviceError where a port is taken.
  config::BusConfig Serve(const config::BusConfig& bus, Port port = Port::kFree);

  // The operator cools (or heats) the gyro unit and puts it back.
  void SetTemperature(double degC);
  // The same to the scenario's thermal.cooled_degC.
  void ColdSoak();
  // The operator switches the fan that cools the gyro unit, or a heater that warms it.
  void SetFan(bool blows);
  void SetHeater(bool heats);

  // For tests: the truth.
  Physics& physics();

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace gyrobench::stand
