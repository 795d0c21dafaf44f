#include "tests/daemon/fake_stand.h"

#include <cmath>
#include <random>

namespace gyrobench::daemon {

using drivers::FakeAngleSensor;
using drivers::FakeAxis;
using drivers::FakeGyro;
using drivers::FakeRelays;

config::StandConfig StandOfFakes() {
  config::StandConfig stand;
  config::BusConfig bus;
  bus.name = "a";
  stand.buses = {bus};
  for (const char* name : {"outer", "middle", "inner"}) {
    config::AxisConfig axis;
    axis.name = name;
    axis.drive.bus = axis.encoder.bus = "a";
    axis.encoder.rate_hz = 50.0;
    axis.encoder.idle_rate_hz = 2.0;
    axis.min_deg = -180.0;
    axis.max_deg = 180.0;
    stand.axes.push_back(axis);
  }
  stand.gyro.bus = "a";
  stand.gyro.rate_hz = 200.0;
  stand.gyro.map.max_samples_per_block = 12;
  stand.gyro.map.tick_rate_hz = 62500.0;
  config::RelaysConfig relays;
  relays.bus = "a";
  relays.channels = {{"fan", 0}, {"heater", 1}};
  relays.heater_max_degC = 50.0;
  stand.relays = relays;
  stand.safety.silence_s = 1.0;
  return stand;
}

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
  const double lsb_per_deg_s = identity.gyro_lsb_per_deg_s;
  // Without noise it would pass for a gyro that hangs.
  const auto sample_at = [this, lsb_per_deg_s, random = std::minstd_rand(1),
                          noise_lsb =
                              std::normal_distribution<double>(0.0, 3.0)](Utime utime) mutable {
    drivers::GyroRawSample sample;
    for (std::int16_t& lsb : sample.gyro_lsb)
      lsb = static_cast<std::int16_t>(std::lround(noise_lsb(random)));
    if (const auto inner = drives.find("inner"); inner != drives.end())
      sample.gyro_lsb[2] +=
          static_cast<std::int16_t>(std::lround(lsb_per_deg_s * inner->second->RateDegSAt(utime)));
    sample.accel_lsb = {0, 0, 16384};
    sample.temperature_degC = temperature_degC;
    return sample;
  };
  auto made = std::make_unique<FakeGyro>(identity, clock_, sample_at);
  gyro = made.get();
  return made;
}

std::unique_ptr<drivers::Relays> FakeStand::MakeRelays(const config::RelaysConfig&) {
  auto made = std::make_unique<FakeRelays>();
  relays = made.get();
  return made;
}

}  // namespace gyrobench::daemon
