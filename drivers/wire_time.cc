#include "drivers/wire_time.h"

#include <algorithm>

#include "config/bus_load.h"

namespace gyrobench::drivers {

Utime WireTime(const config::BusConfig& bus, double bytes) {
  if (bus.transport == config::BusConfig::Transport::kTcp) return 0;
  const int bits = 1 + 8 + (bus.parity == 'N' ? 0 : 1) + bus.stop_bits;
  return FromSeconds(bytes * bits / bus.baud);
}

Utime FrameGap(const config::BusConfig& bus) { return WireTime(bus, 3.5); }

bool IsSettableBaud(int baud) {
  const std::vector<int>& bauds = config::SettableBauds();
  return std::find(bauds.begin(), bauds.end(), baud) != bauds.end();
}

}  // namespace gyrobench::drivers
