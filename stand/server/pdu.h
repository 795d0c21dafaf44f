// Modbus application protocol: a request to a device, its answer.
#pragma once

#include <cstdint>
#include <span>

#include "stand/devices/device.h"

namespace gyrobench::stand {

inline constexpr std::size_t kMaxPdu = 253;

// Answers one request (function code and data) into `reply`, which holds kMaxPdu bytes. Returns the
// length of the answer. Functions 3, 4, 6, 16; all else, and what is malformed, gets an exception.
// `impostor`: the device shows another identity.
std::size_t AnswerPdu(Device& device, std::span<const std::uint8_t> request, Utime at,
                      bool impostor, std::span<std::uint8_t> reply);

}  // namespace gyrobench::stand
