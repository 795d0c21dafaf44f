// A relay unit with one Modbus coil a channel.
#pragma once

#include <cstdint>
#include <map>
#include <string>
#include <vector>

#include "config/stand_config.h"
#include "drivers/modbus_bus.h"
#include "drivers/relays.h"

namespace gyrobench::drivers {

class RelayUnit final : public Relays {
 public:
  RelayUnit(const config::RelaysConfig& config, ModbusBus& bus);
  void Open() override;
  void Switch(const std::string& output, bool on) override;
  std::map<std::string, bool> Read() override;

 private:
  std::uint16_t CoilOf(int channel) const;
  void Expect(const std::string& output, bool on);

  const config::RelaysConfig config_;
  const ModbusUnit unit_;
  ModbusBus& bus_;
  std::vector<std::uint8_t> coils_;  // as read last, by channel
};

}  // namespace gyrobench::drivers
