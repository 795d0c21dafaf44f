#include "stand/server/modbus.h"

#include <algorithm>
#include <array>

namespace gyrobench::stand {
namespace {

constexpr std::array<std::uint16_t, 256> MakeCrcTable() {
  std::array<std::uint16_t, 256> table = {};
  for (std::uint32_t i = 0; i < 256; ++i) {
    std::uint32_t crc = i;
    for (int bit = 0; bit < 8; ++bit) crc = (crc >> 1U) ^ ((crc & 1U) != 0 ? 0xA001U : 0U);
    table[i] = static_cast<std::uint16_t>(crc);
  }
  return table;
}
constexpr auto kCrcTable = MakeCrcTable();

constexpr std::size_t kShortest = 4;  // unit, function, checksum
constexpr std::size_t kMbapHeader = 7;
constexpr std::size_t kLongestTcpRest = 254;  // unit and PDU

// Whole length of a request that begins so; 0 when that cannot be said.
std::size_t RtuLength(std::span<const std::uint8_t> bytes) {
  const std::uint8_t function = bytes[1];
  if (function == 1 || (function >= 3 && function <= 6)) return 8;
  if (function == 16 && bytes.size() >= 7) return 9U + bytes[6];
  return 0;
}

}  // namespace

std::uint16_t Crc16(std::span<const std::uint8_t> bytes) {
  std::uint32_t crc = 0xFFFF;
  for (const std::uint8_t byte : bytes) crc = (crc >> 8U) ^ kCrcTable[(crc ^ byte) & 0xFFU];
  return static_cast<std::uint16_t>(crc);
}

std::optional<Frame> FirstRtuFrame(std::span<const std::uint8_t> bytes) {
  if (bytes.size() < kShortest) return std::nullopt;
  const bool long_write_begun = bytes[1] == 16 && bytes.size() < 7;
  if (long_write_begun) return std::nullopt;
  std::size_t size = RtuLength(bytes);
  // Of an unknown function the end is where the bytes end.
  if (size == 0) size = bytes.size();
  if (bytes.size() < size) return std::nullopt;
  const auto whole = bytes.first(size);
  if (Crc16(whole) != 0) return Frame{.size = bytes.size()};
  return Frame{.size = size, .sound = true, .unit = bytes[0], .pdu = whole.subspan(1, size - 3)};
}

std::optional<Frame> FirstTcpFrame(std::span<const std::uint8_t> bytes) {
  if (bytes.size() < kMbapHeader + 1) return std::nullopt;
  const auto word = [&](std::size_t i) {
    return static_cast<std::uint16_t>(bytes[i] << 8U | bytes[i + 1]);
  };
  const std::size_t rest = word(4);
  if (word(2) != 0 || rest < 2 || rest > kLongestTcpRest) return Frame{.size = bytes.size()};
  const std::size_t size = 6 + rest;
  if (bytes.size() < size) return std::nullopt;
  return Frame{.size = size,
               .sound = true,
               .unit = bytes[6],
               .transaction = word(0),
               .pdu = bytes.subspan(kMbapHeader, size - kMbapHeader)};
}

namespace {

constexpr std::uint8_t kReadCoils = 1, kReadHolding = 3, kReadInput = 4, kWriteCoil = 5,
                       kWriteOne = 6, kWriteMany = 16;
constexpr std::size_t kMostRead = 125, kMostWritten = 123, kMostCoils = 2000;
constexpr std::uint16_t kCoilOn = 0xFF00, kCoilOff = 0;

std::uint16_t Word(std::span<const std::uint8_t> bytes, std::size_t i) {
  return static_cast<std::uint16_t>(bytes[i] << 8U | bytes[i + 1]);
}

std::size_t Refuse(std::uint8_t function, ModbusException why, std::span<std::uint8_t> reply) {
  reply[0] = static_cast<std::uint8_t>(function | 0x80U);
  reply[1] = static_cast<std::uint8_t>(why);
  return 2;
}

std::size_t AnswerRead(Device& device, std::span<const std::uint8_t> request, Utime at,
                       bool impostor, std::span<std::uint8_t> reply) {
  const std::uint8_t function = request[0];
  if (request.size() != 5) return Refuse(function, ModbusException::kIllegalValue, reply);
  const std::uint16_t address = Word(request, 1);
  const std::size_t count = Word(request, 3);
  if (count == 0 || count > kMostRead)
    return Refuse(function, ModbusException::kIllegalValue, reply);
  std::array<std::uint16_t, kMostRead> buffer;
  const std::span<std::uint16_t> words(buffer.data(), count);
  ModbusException failed = device.Read(function, address, words, at);
  if (failed == ModbusException::kNone && impostor) failed = device.Disguise(address, words);
  if (failed != ModbusException::kNone) return Refuse(function, failed, reply);
  reply[0] = function;
  reply[1] = static_cast<std::uint8_t>(2 * count);
  for (std::size_t i = 0; i < count; ++i) {
    reply[2 + 2 * i] = static_cast<std::uint8_t>(words[i] >> 8U);
    reply[3 + 2 * i] = static_cast<std::uint8_t>(words[i] & 0xFFU);
  }
  return 2 + 2 * count;
}

std::size_t AnswerWrite(Device& device, std::span<const std::uint8_t> request, Utime at,
                        std::span<std::uint8_t> reply) {
  const std::uint8_t function = request[0];
  const bool many = function == kWriteMany;
  if (request.size() < 5) return Refuse(function, ModbusException::kIllegalValue, reply);
  const std::size_t count = many ? Word(request, 3) : 1;
  const std::size_t data = many ? 6 : 3;
  const bool fits = count >= 1 && count <= kMostWritten && request.size() == data + 2 * count &&
                    (!many || request[5] == 2 * count);
  if (!fits) return Refuse(function, ModbusException::kIllegalValue, reply);
  std::array<std::uint16_t, kMostWritten> words;
  for (std::size_t i = 0; i < count; ++i) words[i] = Word(request, data + 2 * i);
  const auto failed = device.Write(Word(request, 1), {words.data(), count}, at);
  if (failed != ModbusException::kNone) return Refuse(function, failed, reply);
  std::copy_n(request.begin(), 5, reply.begin());
  return 5;
}

std::size_t AnswerReadCoils(Device& device, std::span<const std::uint8_t> request,
                            std::span<std::uint8_t> reply) {
  if (request.size() != 5) return Refuse(kReadCoils, ModbusException::kIllegalValue, reply);
  const std::size_t count = Word(request, 3);
  if (count == 0 || count > kMostCoils)
    return Refuse(kReadCoils, ModbusException::kIllegalValue, reply);
  std::array<bool, kMostCoils> coils;
  const auto failed = device.ReadCoils(Word(request, 1), {coils.data(), count});
  if (failed != ModbusException::kNone) return Refuse(kReadCoils, failed, reply);
  const std::size_t bytes = (count + 7) / 8;
  reply[0] = kReadCoils;
  reply[1] = static_cast<std::uint8_t>(bytes);
  std::fill_n(reply.begin() + 2, bytes, std::uint8_t{0});
  for (std::size_t i = 0; i < count; ++i) {
    if (coils[i]) reply[2 + i / 8] |= static_cast<std::uint8_t>(1U << (i % 8));
  }
  return 2 + bytes;
}

std::size_t AnswerWriteCoil(Device& device, std::span<const std::uint8_t> request, Utime at,
                            std::span<std::uint8_t> reply) {
  const bool fits = request.size() == 5;
  const std::uint16_t value = fits ? Word(request, 3) : 1;
  if (value != kCoilOn && value != kCoilOff)
    return Refuse(kWriteCoil, ModbusException::kIllegalValue, reply);
  const auto failed = device.WriteCoil(Word(request, 1), value == kCoilOn, at);
  if (failed != ModbusException::kNone) return Refuse(kWriteCoil, failed, reply);
  std::copy_n(request.begin(), 5, reply.begin());
  return 5;
}

}  // namespace

std::size_t RefusePdu(std::span<const std::uint8_t> request, int code,
                      std::span<std::uint8_t> reply) {
  return Refuse(request[0], static_cast<ModbusException>(code), reply);
}

std::size_t AnswerPdu(Device& device, std::span<const std::uint8_t> request, Utime at,
                      bool impostor, std::span<std::uint8_t> reply) {
  switch (request[0]) {
    case kReadCoils:
      return AnswerReadCoils(device, request, reply);
    case kWriteCoil:
      return AnswerWriteCoil(device, request, at, reply);
    case kReadHolding:
    case kReadInput:
      return AnswerRead(device, request, at, impostor, reply);
    case kWriteOne:
    case kWriteMany:
      return AnswerWrite(device, request, at, reply);
    default:
      return Refuse(request[0], ModbusException::kIllegalFunction, reply);
  }
}

}  // namespace gyrobench::stand
