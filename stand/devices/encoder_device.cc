#include "stand/devices/encoder_device.h"

#include <algorithm>
#include <array>
#include <utility>

namespace gyrobench::stand {

EncoderDevice::EncoderDevice(std::string name, const config::EncoderMap& map, std::size_t axis,
                             Physics& physics)
    : Device(std::move(name)), map_(map), axis_(axis), physics_(physics) {}

ModbusException EncoderDevice::Read(int function, std::uint16_t address,
                                    std::span<std::uint16_t> words, Utime at) {
  if (function != map_.function) return ModbusException::kIllegalFunction;
  const std::size_t first = static_cast<std::uint16_t>(address - map_.address);
  const auto size = static_cast<std::size_t>(map_.words);
  if (first + words.size() > size) return ModbusException::kIllegalAddress;
  const std::uint32_t counts = physics_.EncoderCounts(axis_, at);
  std::array<std::uint16_t, 2> all = {High(counts), Low(counts)};
  if (map_.word_order == config::WordOrder::kLowFirst) std::swap(all[0], all[1]);
  if (size == 1) all[0] = Low(counts);
  std::copy_n(all.begin() + static_cast<std::ptrdiff_t>(first), words.size(), words.begin());
  return ModbusException::kNone;
}

ModbusException EncoderDevice::Write(std::uint16_t /*address*/,
                                     std::span<const std::uint16_t> /*words*/, Utime /*at*/) {
  return ModbusException::kIllegalAddress;
}

// It has no identity; another device would not have this register.
ModbusException EncoderDevice::Disguise(std::uint16_t /*address*/,
                                        std::span<std::uint16_t> /*words*/) {
  return ModbusException::kIllegalAddress;
}

}  // namespace gyrobench::stand
