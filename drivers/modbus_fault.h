// What libmodbus's error numbers mean to the person at the bench.
#pragma once

#include <string>

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

}  // namespace gyrobench::drivers
