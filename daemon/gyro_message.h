// A block of the gyro unit as a message.
#pragma once

#include "drivers/gyro.h"
#include "gyrobench/gyro_t.hpp"

namespace gyrobench::daemon {

// All fields of `message` but run_id and seq; its memory is used again.
void FillMessage(const drivers::GyroBlock& block, const drivers::GyroIdentity& identity,
                 gyro_t& message);

}  // namespace gyrobench::daemon
