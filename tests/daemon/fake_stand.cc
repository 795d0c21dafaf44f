#include "tests/daemon/fake_stand.h"

namespace gyrobench::daemon {

using drivers::FakeAngleSensor;
using drivers::FakeAxis;
using drivers::FakeGyro;
using drivers::FakeRelays;

std::unique_ptr<drivers::Axis> FakeStand::MakeAxis(const config::AxisConfig& config) {
  auto axis = std::make_unique<FakeAxis>(config.name, clock_);
  drives[config.name] = axis.get();
  return axis;
}

std::unique_ptr<drivers::AngleSensor> FakeStand::MakeAngleSensor(const config::AxisConfig& config) {
  const auto shown_deg = [this, name = config.name](Utime) {
    return drives.at(name)->AngleDeg() + off_deg[name];
  };
  auto encoder = std::make_unique<FakeAngleSensor>(config.name, clock_, shown_deg);
  encoders[config.name] = encoder.get();
  return encoder;
}

std::unique_ptr<drivers::Gyro> FakeStand::MakeGyro(const config::GyroConfig& config) {
  drivers::GyroIdentity identity;
  identity.serial_number = 17;
  identity.tick_rate_hz = config.map.tick_rate_hz;
  identity.sample_rate_hz = config.rate_hz;
  identity.gyro_lsb_per_deg_s = 131.0;
  identity.accel_lsb_per_g = 16384.0;
  const auto at_rest = [](Utime) {
    drivers::GyroRawSample sample;
    sample.accel_lsb = {0, 0, 16384};
    sample.temperature_degC = 25.0;
    return sample;
  };
  auto made = std::make_unique<FakeGyro>(identity, clock_, at_rest);
  gyro = made.get();
  return made;
}

std::unique_ptr<drivers::Relays> FakeStand::MakeRelays(const config::RelaysConfig&) {
  auto made = std::make_unique<FakeRelays>();
  relays = made.get();
  return made;
}

}  // namespace gyrobench::daemon
