#include "stand/devices/gyro_device.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace gyrobench::stand {
namespace {

constexpr std::uint16_t kFirmwareVersion = 0x0100;
constexpr std::size_t kIdentityWords = 11;
constexpr std::size_t kCounterWords = 6;
constexpr std::size_t kSettings = 4;
constexpr std::array<std::uint16_t, kSettings> kHighestSetting = {3, 6, 255, 3};

std::array<std::uint16_t, kSettings> ToWords(const GyroSettings& settings) {
  return {static_cast<std::uint16_t>(settings.range), static_cast<std::uint16_t>(settings.filter),
          static_cast<std::uint16_t>(settings.divider),
          static_cast<std::uint16_t>(settings.accel_range)};
}

// The part of `all`, which begins at `base`, that the request asks for.
template <std::size_t N>
bool CopyRange(const std::array<std::uint16_t, N>& all, std::uint16_t base, std::uint16_t address,
               std::span<std::uint16_t> words) {
  const std::size_t first = static_cast<std::uint16_t>(address - base);
  if (first + words.size() > N) return false;
  std::copy_n(all.begin() + static_cast<std::ptrdiff_t>(first), words.size(), words.begin());
  return true;
}

}  // namespace

GyroDevice::GyroDevice(const config::GyroUnitMap& map, Physics& physics)
    : Device("gyro"),
      map_(map),
      physics_(physics),
      serial_number_(physics.specimen().unit.serial_number),
      boot_count_(physics.specimen().unit.boot_count) {}

ModbusException GyroDevice::Read(int function, std::uint16_t address,
                                 std::span<std::uint16_t> words, Utime at) {
  return physics_.WithGyro(at, [&](const GyroSampler& gyro, double t_s) {
    if (gyro.boot_count() != boot_count_) frames_rejected_ = 0;
    boot_count_ = gyro.boot_count();
    if (function == 4) return ReadInput(address, words, gyro, t_s);
    const bool known = CopyRange(ToWords(gyro.settings()), map_.settings_address, address, words);
    return known ? ModbusException::kNone : ModbusException::kIllegalAddress;
  });
}

ModbusException GyroDevice::ReadInput(std::uint16_t address, std::span<std::uint16_t> words,
                                      const GyroSampler& gyro, double t_s) const {
  const std::size_t block = static_cast<std::uint16_t>(address - map_.block_address);
  if (address >= map_.block_address && block < map_.block_span) {
    ReadBlock(address, words, gyro, t_s);
    return ModbusException::kNone;
  }
  const auto ticks_per_s = static_cast<std::uint32_t>(std::lround(map_.tick_rate_hz));
  const std::array<std::uint16_t, kIdentityWords> identity = {
      map_.magic,
      static_cast<std::uint16_t>(map_.protocol_version),
      kFirmwareVersion,
      High(serial_number_),
      Low(serial_number_),
      static_cast<std::uint16_t>(gyro.boot_count()),
      static_cast<std::uint16_t>(map_.who_am_i),
      High(ticks_per_s),
      Low(ticks_per_s),
      static_cast<std::uint16_t>(std::lround(gyro.sample_rate_hz())),
      GyroSampler::kCapacity};
  if (CopyRange(identity, map_.identity_address, address, words)) return ModbusException::kNone;
  // A sample that is lost is lost to an error of the sensor's bus.
  const std::uint32_t lost = gyro.samples_lost();
  const std::array<std::uint16_t, kCounterWords> counters = {
      High(lost), Low(lost), High(lost), Low(lost), High(frames_rejected_), Low(frames_rejected_)};
  if (CopyRange(counters, map_.counters_address, address, words)) return ModbusException::kNone;
  return ModbusException::kIllegalAddress;
}

// Number of the first sample of the block: the one wanted if the ring has it, the oldest if it is
// gone, the next to come if it is not there yet. `wanted` is known up to a multiple of the span
// only.
std::uint32_t GyroDevice::FirstOfBlock(std::uint16_t wanted_mod_span,
                                       const GyroSampler& gyro) const {
  const std::uint32_t span = map_.block_span;
  const std::uint32_t next = gyro.next_number();
  const std::uint32_t behind = (next % span + span - wanted_mod_span) % span;
  if (behind == 0 || behind > span / 2) return next;
  return std::max(next - std::min(behind, next), gyro.oldest_number());
}

void GyroDevice::ReadBlock(std::uint16_t address, std::span<std::uint16_t> words,
                           const GyroSampler& gyro, double t_s) const {
  const auto header_words = static_cast<std::size_t>(map_.block_header_words);
  const auto sample_words = static_cast<std::size_t>(map_.sample_words);
  const std::uint32_t next = gyro.next_number();
  const std::uint32_t first =
      FirstOfBlock(static_cast<std::uint16_t>(address - map_.block_address), gyro);
  const std::size_t room =
      words.size() > header_words ? (words.size() - header_words) / sample_words : 0;
  const auto count = static_cast<std::uint32_t>(std::min<std::size_t>(next - first, room));
  const std::uint32_t first_tick = next != first ? gyro.sample(first).tick : 0;
  const std::uint32_t now = gyro.TickAt(t_s);
  const std::array<std::uint16_t, 8> header = {High(now),
                                               Low(now),
                                               High(next),
                                               Low(next),
                                               static_cast<std::uint16_t>(gyro.boot_count()),
                                               Low(first),
                                               High(first_tick),
                                               Low(first_tick)};
  std::ranges::fill(words, std::uint16_t{0});
  std::copy_n(header.begin(), std::min(words.size(), header.size()), words.begin());
  std::uint32_t before = first_tick;
  for (std::uint32_t i = 0; i < count; ++i) {
    const RawSample& sample = gyro.sample(first + i);
    const auto out = words.subspan(header_words + i * sample_words, sample_words);
    out[0] = static_cast<std::uint16_t>(std::min<std::uint32_t>(sample.tick - before, 0xFFFF));
    for (std::size_t k = 0; k < sample.words.size(); ++k) {
      out[1 + k] = static_cast<std::uint16_t>(sample.words[k]);
    }
    before = sample.tick;
  }
}

ModbusException GyroDevice::Write(std::uint16_t address, std::span<const std::uint16_t> words,
                                  Utime at) {
  const std::size_t first = static_cast<std::uint16_t>(address - map_.settings_address);
  if (first + words.size() > kSettings) return ModbusException::kIllegalAddress;
  return physics_.WithGyro(at, [&](GyroSampler& gyro, double t_s) {
    auto all = ToWords(gyro.settings());
    for (std::size_t i = 0; i < words.size(); ++i) {
      if (words[i] > kHighestSetting[first + i]) return ModbusException::kIllegalValue;
      all[first + i] = words[i];
    }
    gyro.Set(t_s, {.range = all[0], .filter = all[1], .divider = all[2], .accel_range = all[3]});
    return ModbusException::kNone;
  });
}

ModbusException GyroDevice::Disguise(std::uint16_t address, std::span<std::uint16_t> words) {
  const std::size_t i = static_cast<std::uint16_t>(map_.identity_address - address);
  if (i < words.size()) words[i] = 0x1234;
  return ModbusException::kNone;
}

}  // namespace gyrobench::stand
