// Where the devices of a stand come from.
#pragma once

#include <functional>
#include <memory>
#include <vector>

#include "base/clock.h"
#include "config/stand_config.h"
#include "drivers/angle_sensor.h"
#include "drivers/axis.h"
#include "drivers/gyro.h"
#include "drivers/line_figures.h"
#include "drivers/relays.h"

namespace gyrobench::drivers {

// Makes each device by its configuration, on the bus that this names. A bus is added before its
// devices. Nothing is sent before a device's Open. Each Make throws ConfigError for a register map
// that cannot work.
class DeviceMaker {
 public:
  virtual ~DeviceMaker() = default;
  // The devices of this bus are used by one thread, which waits as `thread` until it ends.
  // `hurries`: something urgent waits for the thread, so that a request that failed is not repeated.
  virtual void AddBus(const config::BusConfig& bus, Clock::Participant& thread,
                      std::function<bool()> hurries) = 0;
  virtual std::unique_ptr<Axis> MakeAxis(const config::AxisConfig& config) = 0;
  virtual std::unique_ptr<AngleSensor> MakeAngleSensor(const config::AxisConfig& config) = 0;
  virtual std::unique_ptr<Gyro> MakeGyro(const config::GyroConfig& config) = 0;
  virtual std::unique_ptr<Relays> MakeRelays(const config::RelaysConfig& config) = 0;
  // How the lines do, in the order of their names; nothing where there are none. From any thread,
  // once all buses were added.
  virtual std::vector<LineFigures> Lines() const { return {}; }
};

}  // namespace gyrobench::drivers
