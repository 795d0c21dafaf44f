#include "stand/devices/relay_device.h"

namespace gyrobench::stand {

RelayDevice::RelayDevice(const config::RelaysConfig& config, Physics& physics)
    : Device("relays"),
      first_coil_(config.map.first_coil),
      channels_(config.channels),
      physics_(physics),
      on_(static_cast<std::size_t>(config.map.channels), false) {}

ModbusException RelayDevice::Read(int /*function*/, std::uint16_t /*address*/,
                                  std::span<std::uint16_t> /*words*/, Utime /*at*/) {
  return ModbusException::kIllegalFunction;
}

ModbusException RelayDevice::Write(std::uint16_t /*address*/,
                                   std::span<const std::uint16_t> /*words*/, Utime /*at*/) {
  return ModbusException::kIllegalFunction;
}

ModbusException RelayDevice::ReadCoils(std::uint16_t address, std::span<bool> coils) {
  const std::size_t first = static_cast<std::uint16_t>(address - first_coil_);
  if (first + coils.size() > on_.size()) return ModbusException::kIllegalAddress;
  for (std::size_t i = 0; i < coils.size(); ++i) coils[i] = on_[first + i];
  return ModbusException::kNone;
}

ModbusException RelayDevice::WriteCoil(std::uint16_t address, bool on, Utime at) {
  const std::size_t channel = static_cast<std::uint16_t>(address - first_coil_);
  if (channel >= on_.size()) return ModbusException::kIllegalAddress;
  on_[channel] = on;
  for (const auto& [output, its_channel] : channels_) {
    if (static_cast<std::size_t>(its_channel) != channel) continue;
    if (output == "fan") physics_.SetFan(at, on);
    if (output == "heater") physics_.SetHeater(at, on);
  }
  return ModbusException::kNone;
}

void RelayDevice::LosePower(Utime at) {
  for (std::size_t i = 0; i < on_.size(); ++i) {
    WriteCoil(static_cast<std::uint16_t>(first_coil_ + i), false, at);
  }
}

// It has no identity; another device would not have this coil.
ModbusException RelayDevice::Disguise(std::uint16_t /*address*/,
                                      std::span<std::uint16_t> /*words*/) {
  return ModbusException::kIllegalAddress;
}

}  // namespace gyrobench::stand
