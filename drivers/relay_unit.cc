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
      coils_(static_cast<std::size_t>(config.map.channels)) {
  for (const auto& [output, channel] : config_.channels) switched_[output] = false;
}

std::uint16_t RelayUnit::CoilOf(int channel) const {
  return static_cast<std::uint16_t>(config_.map.first_coil + channel);
}

void RelayUnit::Open() {
  for (const auto& [output, channel] : config_.channels) Switch(output, false);
}

void RelayUnit::Switch(const std::string& output, bool on) {
  const auto found = config_.channels.find(output);
  if (found == config_.channels.end()) {
    throw LimitError(fmt::format("relays: no output '{}' in the stand file", output));
  }
  bus_.WriteCoil(unit_, CoilOf(found->second), on, output.c_str());
  switched_[output] = on;
  Check();
}

void RelayUnit::Check() {
  bus_.ReadCoils(unit_, CoilOf(0), coils_, "outputs");
  for (const auto& [output, channel] : config_.channels) {
    const bool is_on = coils_[static_cast<std::size_t>(channel)] != 0;
    if (is_on == switched_[output]) continue;
    throw DeviceError(fmt::format(
        "relays ({}, unit {}): {}: coil 0x{:04X} was switched {} and reads {}. Was the unit "
        "restarted, or does somebody else switch it? Check first_coil and the channel against the "
        "unit's manual.",
        bus_.description(), unit_.unit, output, CoilOf(channel), OnOff(switched_[output]),
        OnOff(is_on)));
  }
}

}  // namespace gyrobench::drivers
