// Numbers of more than 16 bits out of Modbus registers, and numbers that wrap.
#pragma once

#include <cstdint>

#include "config/device_maps.h"

namespace gyrobench::config {

constexpr bool IsBitSet(std::uint16_t word, int bit) { return (word >> bit & 1) != 0; }

// As device maps have it.
constexpr const char* NameOf(WordOrder order) {
  return order == WordOrder::kHighFirst ? "high_first" : "low_first";
}

// Two registers as one number.
constexpr std::uint32_t FromWords(std::uint16_t first, std::uint16_t second,
                                  WordOrder order = WordOrder::kHighFirst) {
  const std::uint32_t high = order == WordOrder::kHighFirst ? first : second;
  const std::uint32_t low = order == WordOrder::kHighFirst ? second : first;
  return high << 16 | low;
}

// A number as two registers; `first` is the one at the lower address.
constexpr void ToWords(std::uint32_t value, WordOrder order, std::uint16_t& first,
                       std::uint16_t& second) {
  const auto high = static_cast<std::uint16_t>(value >> 16);
  const auto low = static_cast<std::uint16_t>(value & 0xFFFF);
  first = order == WordOrder::kHighFirst ? high : low;
  second = order == WordOrder::kHighFirst ? low : high;
}

// A signed step between two readings of a number that wraps at `range`: the shorter way round,
// -range/2 < step <= range/2. Both readings must be below `range`, range at most 2^63.
constexpr std::int64_t WrappedStep(std::uint64_t from, std::uint64_t to, std::uint64_t range) {
  const std::uint64_t forward = to >= from ? to - from : range - (from - to);
  return forward <= range / 2 ? static_cast<std::int64_t>(forward)
                              : -static_cast<std::int64_t>(range - forward);
}

// The same for numbers that wrap at 2^32.
constexpr std::int64_t WrappedStep32(std::uint32_t from, std::uint32_t to) {
  return WrappedStep(from, to, std::uint64_t{1} << 32);
}

}  // namespace gyrobench::config
