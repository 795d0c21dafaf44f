#include "stand/server/framing.h"

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

}  // namespace gyrobench::stand
