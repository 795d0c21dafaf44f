// How long bytes take on a serial line.
#pragma once

#include "base/clock.h"
#include "config/stand_config.h"

namespace gyrobench::drivers {

// Time of `bytes` characters on the line: 1 start bit, 8 data bits, the parity bit if there is one,
// and the stop bits, each 1 / baud. 0 for a TCP bus, whose wire time is not ours to know.
Utime WireTime(const config::BusConfig& bus, double bytes);

// The silence of 3.5 characters that ends a Modbus RTU frame. 0 for TCP.
Utime FrameGap(const config::BusConfig& bus);

// True for the rates that libmodbus sets; it turns any other into 9600 without a word.
bool IsSettableBaud(int baud);

}  // namespace gyrobench::drivers
