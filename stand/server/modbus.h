// Modbus in bytes: frames of RTU and TCP, and the application protocol within them.
#pragma once

#include <cstdint>
#include <optional>
#include <span>

#include "stand/devices/device.h"

namespace gyrobench::stand {

// CRC-16 of Modbus (polynomial 0xA001, start 0xFFFF); over a frame with its own CRC behind it is 0.
std::uint16_t Crc16(std::span<const std::uint8_t> bytes);

// One request within `bytes`.
struct Frame {
  std::size_t size = 0;  // bytes it takes, from the beginning
  bool sound = false;    // checksum and header are right
  std::uint8_t unit = 0;
  std::uint16_t transaction = 0;  // TCP only
  std::span<const std::uint8_t> pdu = {};
};

// The first request, or nothing while its end has not come. A damaged one takes all bytes: on a
// line that waits for its answer nothing else can be behind it.
std::optional<Frame> FirstRtuFrame(std::span<const std::uint8_t> bytes);
std::optional<Frame> FirstTcpFrame(std::span<const std::uint8_t> bytes);

inline constexpr std::size_t kMaxPdu = 253;

// Answers one request (function code and data) into `reply`, which holds kMaxPdu bytes. Returns the
// length of the answer. Functions 3, 4, 6, 16; all else, and what is malformed, gets an exception.
// `impostor`: the device shows another identity.
std::size_t AnswerPdu(Device& device, std::span<const std::uint8_t> request, Utime at,
                      bool impostor, std::span<std::uint8_t> reply);

// Refuses a request with exception `code`. Returns the length of the answer.
std::size_t RefusePdu(std::span<const std::uint8_t> request, int code,
                      std::span<std::uint8_t> reply);

}  // namespace gyrobench::stand
