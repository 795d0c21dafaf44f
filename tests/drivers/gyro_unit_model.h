// The gyro unit of docs/gyro-unit.md in memory: identity, counters, settings and a ring of samples.
// Written from the page, apart from driver and virtual stand.
#pragma once

#include <array>
#include <cstdint>
#include <deque>
#include <mutex>

#include "config/device_maps.h"
#include "tests/drivers/fake_line.h"

namespace gyrobench {

// The map as the page has it.
config::GyroUnitMap GyroMapOfThePage();

class GyroUnitModel final : public FakeUnit {
 public:
  struct Sample {
    std::uint32_t tick;
    std::array<std::int16_t, 7> raw;  // accelerometer x, y, z, temperature, gyro x, y, z
  };

  Words Read(int function, std::uint16_t address, std::uint16_t count) override;
  void Write(std::uint16_t address, const Words& values) override;

  // Takes samples of which every field has a value of its own (Raw), each `ticks` after the one
  // before.
  void Take(int samples, std::uint32_t ticks = 1250);
  // Time passes without a sample.
  void Idle(std::uint32_t ticks);
  // Begins anew with the next boot counter, at this tick and with settings lost.
  void Restart(std::uint32_t tick = 0);
  // Where numbers and ticks stand; to be set before the driver opens.
  void StartAt(std::uint32_t number, std::uint32_t tick);
  void SetIdentity(std::size_t word, std::uint16_t value);
  void SetCounters(std::uint32_t lost, std::uint32_t bus_errors, std::uint32_t rejected);
  // From now on each block read of samples that are not there yet takes `samples` first.
  void TakeOnDemand(int samples);
  void LockSettings();
  Words settings() const;
  int settings_written() const;

  static std::array<std::int16_t, 7> Raw(std::uint32_t number);
  static constexpr std::size_t kCapacity = 64;

 private:
  Words Block(std::uint16_t address, std::uint16_t count);
  void TakeLocked(int samples, std::uint32_t ticks);

  mutable std::mutex mutex_;
  Words identity_ = {0x4742, 1, 0x0203, 0x0005, 0x0006, 7, 0x68, 0x0003, 0xD090, 200, kCapacity};
  Words counters_ = {0, 11, 0, 12, 0, 13};
  Words settings_ = {0, 0, 0, 0};
  bool settings_locked_ = false;
  int settings_written_ = 0;
  int on_demand_ = 0;
  std::uint32_t next_ = 0;
  std::uint32_t tick_ = 0;
  std::deque<Sample> ring_;  // the newest has number next_ - 1
};

}  // namespace gyrobench
