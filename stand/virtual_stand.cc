#include "stand/virtual_stand.h"

#include <fmt/format.h>

#include <mutex>
#include <utility>
#include <vector>

#include "stand/bench_physics.h"
#include "stand/devices/drive_device.h"
#include "stand/devices/encoder_device.h"
#include "stand/devices/gyro_device.h"
#include "stand/devices/relay_device.h"
#include "stand/server/bus_server.h"

namespace gyrobench::stand {
namespace {

std::uint64_t SeedOf(const config::StandConfig& stand) {
  return stand.virtual_stand ? stand.virtual_stand->seed : 1;
}

}  // namespace

struct VirtualStand::Impl {
  Impl(const config::StandConfig& stand_config, const config::Scenario& scenario,
       std::uint64_t noise_seed, Clock& its_clock, MakeGyroUnit its_gyro_unit)
      : stand(stand_config),
        seed(noise_seed),
        clock(its_clock),
        start(clock.Now()),
        make_gyro_unit(std::move(its_gyro_unit)),
        physics(stand, DrawSpecimen(scenario, seed), seed, start) {}

  std::unique_ptr<Responder> MakeResponder(const config::BusConfig& bus) {
    const LineTiming timing(bus, physics.specimen().bus);
    auto responder =
        std::make_unique<Responder>(bus.name, clock, start, timing, physics.faults(), seed);
    for (const config::AxisConfig& axis : stand.axes) {
      const std::size_t index = AxisIndex(axis.name);
      if (axis.drive.bus == bus.name) {
        responder->Add(axis.drive.unit, std::make_unique<DriveDevice>(
                                            axis.name + ".drive", axis.drive.map, index, physics));
      }
      if (axis.encoder.bus == bus.name) {
        responder->Add(axis.encoder.unit,
                       std::make_unique<EncoderDevice>(axis.name + ".encoder", axis.encoder.map,
                                                       index, physics));
      }
    }
    if (stand.gyro.bus == bus.name) {
      responder->Add(stand.gyro.unit, make_gyro_unit
                                          ? make_gyro_unit(physics, start)
                                          : std::make_unique<GyroDevice>(stand.gyro.map, physics));
    }
    if (stand.relays && stand.relays->bus == bus.name) {
      responder->Add(stand.relays->unit, std::make_unique<RelayDevice>(*stand.relays, physics));
    }
    return responder;
  }

  const config::StandConfig stand;
  const std::uint64_t seed;
  Clock& clock;
  const Utime start;
  const MakeGyroUnit make_gyro_unit;
  Physics physics;
  std::mutex mutex;  // guards what follows: lines may be opened side by side
  std::vector<std::unique_ptr<BusServer>> servers;
};

VirtualStand::VirtualStand(const config::StandConfig& stand, const config::Scenario& scenario,
                           std::uint64_t seed, Clock& clock, MakeGyroUnit make_gyro_unit)
    : impl_(std::make_unique<Impl>(stand, scenario, seed, clock, std::move(make_gyro_unit))) {}

VirtualStand::VirtualStand(const config::StandConfig& stand, const config::Scenario& scenario,
                           Clock& clock)
    : VirtualStand(stand, scenario, SeedOf(stand), clock) {}

VirtualStand::~VirtualStand() = default;

config::BusConfig VirtualStand::Serve(const config::BusConfig& bus, Port port) {
  const std::lock_guard lock(impl_->mutex);
  config::BusConfig served = bus;
  auto responder = impl_->MakeResponder(bus);
  if (bus.transport == config::BusConfig::Transport::kRtu) {
    auto server = std::make_unique<RtuServer>(std::move(responder));
    served.device = server->device();
    impl_->servers.push_back(std::move(server));
  } else {
    const bool free = port == Port::kFree;
    served.host = free ? "127.0.0.1" : bus.host;
    auto server =
        std::make_unique<TcpServer>(std::move(responder), served.host, free ? 0 : bus.port);
    served.port = server->port();
    impl_->servers.push_back(std::move(server));
  }
  impl_->servers.back()->Start();
  return served;
}

void VirtualStand::SetTemperature(double degC) {
  impl_->physics.SetTemperature(impl_->clock.Now(), degC);
}

void VirtualStand::ColdSoak() { SetTemperature(impl_->physics.specimen().thermal.cooled_degC); }

void VirtualStand::SetFan(bool blows) { impl_->physics.SetFan(impl_->clock.Now(), blows); }

void VirtualStand::SetHeater(bool heats) { impl_->physics.SetHeater(impl_->clock.Now(), heats); }

Physics& VirtualStand::physics() { return impl_->physics; }

}  // namespace gyrobench::stand
