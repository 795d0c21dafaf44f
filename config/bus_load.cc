#include "config/bus_load.h"

#include <algorithm>

namespace gyrobench::config {
namespace {

constexpr double kDrivePolls_hz = 2.0;
constexpr double kRelayPolls_hz = 2.0;
// Unit, function, address, count, CRC.
constexpr int kReadRequestBytes = 8;
// Unit, function, byte count, CRC.
constexpr int kReadReplyBytes = 5;
constexpr double kSilenceCharacters = 3.5;

double CharacterTime_s(const BusConfig& bus) {
  const int bits = 1 + 8 + (bus.parity == 'N' ? 0 : 1) + bus.stop_bits;
  return static_cast<double>(bits) / bus.baud;
}

double ReadTime_s(const BusConfig& bus, int words) {
  const int bytes = kReadRequestBytes + kReadReplyBytes + 2 * words;
  return (bytes + 2 * kSilenceCharacters) * CharacterTime_s(bus);
}

}  // namespace

const std::vector<int>& SettableBauds() {
  static const std::vector<int> bauds = {110,     300,     600,     1200,    2400,    4800,
                                         9600,    19200,   38400,   57600,   115200,  230400,
                                         460800,  500000,  576000,  921600,  1000000, 1152000,
                                         1500000, 2500000, 3000000, 3500000, 4000000};
  return bauds;
}

std::vector<DeviceLoad> BusLoad(const StandConfig& stand, const BusConfig& bus) {
  std::vector<DeviceLoad> loads;
  if (bus.transport == BusConfig::Transport::kTcp) return loads;
  for (const AxisConfig& axis : stand.axes) {
    if (axis.drive.bus == bus.name) {
      const double poll_s = ReadTime_s(bus, 1) + ReadTime_s(bus, 2);
      loads.push_back({"axis." + axis.name + ".drive", kDrivePolls_hz * poll_s});
    }
    if (axis.encoder.bus == bus.name) {
      const double poll_s = ReadTime_s(bus, axis.encoder.map.words);
      loads.push_back({"axis." + axis.name + ".encoder", axis.encoder.rate_hz * poll_s});
    }
  }
  if (stand.gyro.bus == bus.name) {
    const GyroUnitMap& map = stand.gyro.map;
    const int words = map.block_header_words + map.sample_words * map.max_samples_per_block;
    const double blocks_hz = stand.gyro.rate_hz / std::max(1, map.max_samples_per_block - 1);
    loads.push_back({"gyro", blocks_hz * ReadTime_s(bus, words)});
  }
  if (stand.relays && stand.relays->bus == bus.name) {
    // A reply of up to 32 coils is no longer than one of two registers.
    loads.push_back({"relays", kRelayPolls_hz * ReadTime_s(bus, 2)});
  }
  return loads;
}

}  // namespace gyrobench::config
