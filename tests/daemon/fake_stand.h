// A stand whose devices are in memory: for tests of what is above the drivers, without a bus.
#pragma once

#include <atomic>
#include <functional>
#include <map>
#include <memory>
#include <string>

#include "config/stand_config.h"
#include "drivers/device_maker.h"
#include "tests/drivers/fake_devices.h"

namespace gyrobench::daemon {

// Three axes, a gyro, a fan and a heater on one bus.
config::StandConfig StandOfFakes();

// The sensor of an axis shows where its drive is, and `off_deg` more; the gyro's z axis feels the
// inner axis alone, and it has 25 degC. While the test's thread does not wait for the clock, no bus
// is at work, and it may look at the devices and change them.
class FakeStand final : public drivers::DeviceMaker {
 public:
  explicit FakeStand(const Clock& clock) : clock_(clock) {}

  void AddBus(const config::BusConfig&, Clock::Participant&, std::function<bool()>) override {}
  std::unique_ptr<drivers::Axis> MakeAxis(const config::AxisConfig& config) override;
  std::unique_ptr<drivers::AngleSensor> MakeAngleSensor(const config::AxisConfig& config) override;
  std::unique_ptr<drivers::Gyro> MakeGyro(const config::GyroConfig& config) override;
  std::unique_ptr<drivers::Relays> MakeRelays(const config::RelaysConfig& config) override;

  // Owned by who had them made.
  std::map<std::string, drivers::FakeAxis*> drives;  // by the name of the axis
  std::map<std::string, drivers::FakeAngleSensor*> encoders;
  std::map<std::string, double> off_deg;
  std::atomic<double> temperature_degC = 25.0;  // read by the bus of the gyro
  drivers::FakeGyro* gyro = nullptr;
  drivers::FakeRelays* relays = nullptr;

 private:
  const Clock& clock_;
};

}  // namespace gyrobench::daemon
