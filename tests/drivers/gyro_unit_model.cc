#include "tests/drivers/gyro_unit_model.h"

#include <algorithm>

namespace gyrobench {

config::GyroUnitMap GyroMapOfThePage() {
  config::GyroUnitMap map;
  map.model = "gyro unit of the test";
  map.gyro_range_deg_s = {250, 500, 1000, 2000};
  map.gyro_lsb_per_deg_s = {131, 65.5, 32.8, 16.4};
  map.accel_range_g = {2, 4, 8, 16};
  map.accel_lsb_per_g = {16384, 8192, 4096, 2048};
  map.filter_bandwidth_hz = {256, 188, 98, 42, 20, 10, 5};
  map.filter_delay_s = {0.98e-3, 1.9e-3, 2.8e-3, 4.8e-3, 8.3e-3, 13.4e-3, 18.6e-3};
  return map;
}

std::array<std::int16_t, 7> GyroUnitModel::Raw(std::uint32_t number) {
  const auto n = static_cast<int>(number % 1000);
  const auto field = [n](int base, int sign) {
    return static_cast<std::int16_t>(sign * (base + n));
  };
  return {field(1000, 1),  field(3000, -1), field(5000, 1),  field(7000, -1),
          field(9000, -1), field(11000, 1), field(13000, -1)};
}

void GyroUnitModel::TakeLocked(int samples, std::uint32_t ticks) {
  for (int i = 0; i < samples; ++i) {
    tick_ += ticks;
    ring_.push_back({tick_, Raw(next_)});
    ++next_;
    if (ring_.size() > kCapacity) ring_.pop_front();
  }
}

void GyroUnitModel::Take(int samples, std::uint32_t ticks) {
  const std::lock_guard lock(mutex_);
  TakeLocked(samples, ticks);
}

void GyroUnitModel::Idle(std::uint32_t ticks) {
  const std::lock_guard lock(mutex_);
  tick_ += ticks;
}

void GyroUnitModel::Restart(std::uint32_t tick) {
  const std::lock_guard lock(mutex_);
  ++identity_[5];
  next_ = 0;
  tick_ = tick;
  ring_.clear();
  settings_ = {0, 0, 0, 0};
}

void GyroUnitModel::StartAt(std::uint32_t number, std::uint32_t tick) {
  const std::lock_guard lock(mutex_);
  next_ = number;
  tick_ = tick;
}

void GyroUnitModel::SetIdentity(std::size_t word, std::uint16_t value) {
  const std::lock_guard lock(mutex_);
  identity_.at(word) = value;
}

void GyroUnitModel::SetCounters(std::uint32_t lost, std::uint32_t bus_errors,
                                std::uint32_t rejected) {
  const std::lock_guard lock(mutex_);
  counters_.clear();
  for (const std::uint32_t value : {lost, bus_errors, rejected}) {
    counters_.push_back(static_cast<std::uint16_t>(value >> 16));
    counters_.push_back(static_cast<std::uint16_t>(value & 0xFFFF));
  }
}

void GyroUnitModel::TakeOnDemand(int samples) {
  const std::lock_guard lock(mutex_);
  on_demand_ = samples;
}

void GyroUnitModel::LockSettings() {
  const std::lock_guard lock(mutex_);
  settings_locked_ = true;
}

Words GyroUnitModel::settings() const {
  const std::lock_guard lock(mutex_);
  return settings_;
}

int GyroUnitModel::settings_written() const {
  const std::lock_guard lock(mutex_);
  return settings_written_;
}

Words GyroUnitModel::Read(int function, std::uint16_t address, std::uint16_t count) {
  const std::lock_guard lock(mutex_);
  const auto part = [&](const Words& words, int first) -> Words {
    const int from = address - first;
    if (from < 0 || from + count > static_cast<int>(words.size())) throw ModbusException{2};
    return {words.begin() + from, words.begin() + from + count};
  };
  if (function == 3) return part(settings_, 0x0100);
  if (address >= 0x4000 && address < 0x8000) return Block(address, count);
  return address >= 0x0010 ? part(counters_, 0x0010) : part(identity_, 0);
}

Words GyroUnitModel::Block(std::uint16_t address, std::uint16_t count) {
  if (count < 8 || count % 8 != 0 || count > 120) throw ModbusException{3};
  // The number nearest to the newest that the address can mean.
  const auto step = static_cast<std::uint16_t>((address - 0x4000U - next_) & 0x3FFF);
  const int offset = step >= 0x2000 ? step - 0x4000 : step;
  if (offset >= 0) TakeLocked(on_demand_, 1250);
  const std::size_t back = offset >= 0 ? static_cast<std::size_t>(offset == 0 ? on_demand_ : 0)
                                       : static_cast<std::size_t>(-offset);
  const std::size_t available = std::min(back, ring_.size());
  const std::size_t samples = std::min<std::size_t>(available, (count - 8U) / 8U);
  const std::uint32_t first = next_ - static_cast<std::uint32_t>(available);

  Words words(count, 0);
  const auto put = [&](std::size_t at, std::uint32_t value) {
    words[at] = static_cast<std::uint16_t>(value >> 16);
    words[at + 1] = static_cast<std::uint16_t>(value & 0xFFFF);
  };
  put(0, tick_);
  put(2, next_);
  words[4] = identity_[5];
  words[5] = static_cast<std::uint16_t>(first & 0xFFFF);
  if (available > 0) put(6, ring_[ring_.size() - available].tick);
  for (std::size_t i = 0; i < samples; ++i) {
    const Sample& sample = ring_[ring_.size() - available + i];
    const std::uint32_t delta =
        i == 0 ? 0 : sample.tick - ring_[ring_.size() - available + i - 1].tick;
    words[8 + 8 * i] = static_cast<std::uint16_t>(std::min<std::uint32_t>(delta, 0xFFFF));
    for (std::size_t k = 0; k < 7; ++k) {
      words[9 + 8 * i + k] = static_cast<std::uint16_t>(sample.raw[k]);
    }
  }
  return words;
}

void GyroUnitModel::Write(std::uint16_t address, const Words& values) {
  const std::lock_guard lock(mutex_);
  for (std::size_t i = 0; i < values.size(); ++i) {
    ++settings_written_;
    if (!settings_locked_) settings_.at(address - 0x0100U + i) = values[i];
  }
  ring_.clear();
}

}  // namespace gyrobench
