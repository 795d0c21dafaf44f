#include "drivers/relay_unit.h"

#include <fmt/format.h>

#include "base/error.h"

namespace gyrobench::drivers {
namespace {

const char* OnOff(bool on) { return on ? "on" : "off"; }

}  // namespace

RelayUnit::RelayUnit(const config::RelaysConfig& config, ModbusBus& bus)
    : config_(config),
      unit_{"relays", config.unit},
      bus_(bus),
      coils_(static_cast<std::size_t>(config.map.channels)) {}

std::uint16_t RelayUnit::CoilOf(int channel) const {
  return static_cast<std::uint16_t>(config_.map.first_coil + channel);
}

// All are written before any is judged, the heater first.
void RelayUnit::Open() {
  for (auto it = config_.channels.rbegin(); it != config_.channels.rend(); ++it) {
    bus_.WriteCoil(unit_, CoilOf(it->second), false, it->first.c_str());
  }
  for (const auto& [output, channel] : config_.channels) Expect(output, false);
}

void RelayUnit::Switch(const std::string& output, bool on) {
  const auto found = config_.channels.find(output);
  if (found == config_.channels.end()) {
    throw LimitError(fmt::format("the stand file's [relays] has no {}", output));
  }
  bus_.WriteCoil(unit_, CoilOf(found->second), on, output.c_str());
  Expect(output, on);
}

std::map<std::string, bool> RelayUnit::Read() {
  bus_.ReadCoils(unit_, CoilOf(0), coils_, "outputs");
  std::map<std::string, bool> states;
  for (const auto& [output, channel] : config_.channels) {
    states[output] = coils_[static_cast<std::size_t>(channel)] != 0;
  }
  return states;
}

void RelayUnit::Expect(const std::string& output, bool on) {
  if (Read().at(output) == on) return;
  throw DeviceError(
      fmt::format("relays ({}, unit {}): {}: coil 0x{:04X} was switched {} and reads {}. Check "
                  "first_coil and "
                  "the channel against the unit's manual.",
                  bus_.description(), unit_.unit, output, CoilOf(config_.channels.at(output)),
                  OnOff(on), OnOff(!on)),
      {.device = unit_.name, .action = output, .address = CoilOf(config_.channels.at(output))});
}

}  // namespace gyrobench::drivers
