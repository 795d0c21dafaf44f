// The checksum of an event in a log. It stands where LCM has a number that none of its own tools
// judges by: in the upper half of the event's number, of which the lower half counts far enough for
// a century. So an event is as long as ever, is proved by itself, also where all around it is
// damaged, and a log is played by lcm-logplayer as ever.
#pragma once

#include <zlib.h>

#include <array>
#include <cstddef>
#include <cstdint>

namespace gyrobench::recording {

inline constexpr std::size_t kEventNumberAt =
    4;  // in an event, its upper half; the lower one follows

// CRC-32 (zlib, IEEE 802.3) of the bytes of an event, header included, in which the upper half of
// the number counts as zero; its highest bit left out, so that the number stays positive. Never 0,
// which stands for an event that has no checksum: one of another logger, or of gyrobench 0.1.
inline std::uint32_t EventChecksum(const std::uint8_t* event, std::size_t size) {
  constexpr std::array<std::uint8_t, 4> kNothing{};
  uLong crc = crc32(0, event, kEventNumberAt);
  crc = crc32(crc, kNothing.data(), kNothing.size());
  constexpr std::size_t kBehind = kEventNumberAt + kNothing.size();
  crc = crc32_z(crc, event + kBehind, size - kBehind);
  const auto checksum = static_cast<std::uint32_t>(crc & 0x7FFF'FFFF);
  return checksum == 0 ? 1 : checksum;
}

}  // namespace gyrobench::recording
