// What a serial line can carry.
#pragma once

#include <string>
#include <vector>

#include "config/stand_config.h"

namespace gyrobench::config {

// Baud rates that libmodbus 3.1.6 sets on Linux (tried on a pseudo-terminal, read back with
// tcgetattr). Any other silently becomes 9600: 14400, 76800, 128000, 250000, 256000 and 2000000
// among them.
const std::vector<int>& SettableBauds();

// Share of a line's time that one device's polling takes, 1 = all of it.
struct DeviceLoad {
  std::string device;  // "axis.inner.encoder", "gyro"
  double share = 0.0;
};

// Load of an RTU bus while a run uses all axes at once: bytes of requests and replies and the 3.5
// characters of silence after each, over the time between polls. Devices answer at once here, so
// that true load is a little more. Empty for TCP, whose wire time is not ours to know.
//   encoder: rate_hz reads of `words` registers
//   drive:   2 reads a second of status (1 register) and position (2 registers)
//   gyro:    rate_hz / (max_samples_per_block - 1) reads of a full block
std::vector<DeviceLoad> BusLoad(const StandConfig& stand, const BusConfig& bus);

}  // namespace gyrobench::config
