#include "drivers/wire_time.h"

#include <algorithm>
#include <array>

namespace gyrobench::drivers {

Utime WireTime(const config::BusConfig& bus, double bytes) {
  if (bus.transport == config::BusConfig::Transport::kTcp) return 0;
  const int bits = 1 + 8 + (bus.parity == 'N' ? 0 : 1) + bus.stop_bits;
  return FromSeconds(bytes * bits / bus.baud);
}

Utime FrameGap(const config::BusConfig& bus) { return WireTime(bus, 3.5); }

bool IsSettableBaud(int baud) {
  // modbus-rtu.c of libmodbus 3.1.6, as built on Linux.
  static constexpr std::array kRates = {110,     300,     600,     1200,    2400,    4800,
                                        9600,    19200,   38400,   57600,   115200,  230400,
                                        460800,  500000,  576000,  921600,  1000000, 1152000,
                                        1500000, 2500000, 3000000, 3500000, 4000000};
  return std::find(kRates.begin(), kRates.end(), baud) != kRates.end();
}

}  // namespace gyrobench::drivers
