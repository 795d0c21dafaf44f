// A Modbus line: how long bytes take on it, and what libmodbus's error numbers mean to the person
// at the bench.
#pragma once

#include <string>

#include "base/clock.h"
#include "base/error.h"
#include "config/stand_config.h"

namespace gyrobench::drivers {

// True when the device answered with a Modbus exception: the line is in order.
bool IsException(int error);
// True for the exceptions that may pass by themselves: device busy, and a gateway whose device was
// silent.
bool IsPassingException(int error);
// True when the connection or the serial adapter itself is gone.
bool IsLinkLost(int error);

// The number as it stands in an error's fields: exception code, errno, or libmodbus's own.
DeviceFailure::CodeKind CodeKindOf(int error);
int CodeOf(int error);

// "exception 02 (illegal data address)", "a reply with a wrong checksum (CRC)", ...
std::string DescribeFault(int error);
// What to look at, as a sentence.
std::string AdviceForFault(int error, const config::BusConfig& bus);
// "bus A (/dev/ttyUSB0, 115200 baud 8N1)" or "bus A (Modbus TCP stand.lab:502)".
std::string DescribeBus(const config::BusConfig& bus);

// Time of `bytes` characters on the line: 1 start bit, 8 data bits, the parity bit if there is one,
// and the stop bits, each 1 / baud. 0 for a TCP bus, whose wire time is not ours to know.
Utime WireTime(const config::BusConfig& bus, double bytes);

// The silence of 3.5 characters that ends a Modbus RTU frame. 0 for TCP.
Utime FrameGap(const config::BusConfig& bus);

// True for the rates that libmodbus sets; it turns any other into 9600 without a word.
bool IsSettableBaud(int baud);

}  // namespace gyrobench::drivers
