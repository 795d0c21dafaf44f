// The gyro's microcontroller over Modbus, as docs/gyro-unit.md has it.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>

#include "base/tick_fit.h"
#include "config/stand_config.h"
#include "drivers/gyro.h"
#include "drivers/modbus_bus.h"

namespace gyrobench::drivers {

// Reads the unit's ring by sample number: a lost reply is asked for again and loses nothing. Sample
// numbers and ticks (32 bits in the unit) are unwrapped; between two reads may pass at most half a
// wrap of the tick, 2.4 h at 250 kHz. A boot counter that changed makes everything begin anew:
// settings are checked and written again, numbers, ticks and the fit of the clocks start over, and
// that read brings no samples.
class GyroUnit final : public Gyro {
 public:
  // Throws ConfigError for a range, filter or rate that the map does not have.
  GyroUnit(const config::GyroConfig& config, ModbusBus& bus);
  const std::string& name() const override { return unit_.name; }
  GyroIdentity Open() override;
  // One request brings up to max_samples_per_block samples; more are made for what the ring held at
  // the first, never for what comes in meanwhile. The unit's counters are read along every 5 s.
  // Sample times are those of a line through the last minute of (tick, host time) pairs and
  // increase strictly. A reply that is older than the one before is not used: DeviceError when they
  // keep coming.
  void Read(GyroBlock& block) override;

 private:
  static constexpr std::size_t kMostWords = 125;

  // The head of a reply to a block read.
  struct Head {
    std::uint32_t tick = 0;
    std::uint32_t next = 0;
    std::uint16_t boot = 0;
    std::uint16_t first = 0;
    std::uint32_t first_tick = 0;
  };

  void Identify();
  void CheckIdentity(const std::array<std::uint16_t, 11>& words) const;
  void ApplySettings();
  void Begin();
  void StartAnew(GyroBlock& block);
  Head Request(std::size_t samples, Timing& timing);
  Head RequestFresh(Timing& timing);
  bool IsStale(const Head& head, const Timing& timing) const;
  void Advance(const Head& head, const Timing& timing);
  void CountWhatPassed();
  void Publish(GyroBlock& block);
  void Take(const Head& head, GyroBlock& block);
  void Append(std::int64_t number, std::int64_t tick, std::size_t word, GyroBlock& block);
  void ReadCounters();
  std::optional<Utime> BootTime() const;
  Utime HostTime(std::int64_t tick) const;
  [[noreturn]] void Fail(const std::string& text, DeviceFailure fields) const;

  const config::GyroConfig config_;
  const config::GyroUnitMap& map_;
  const ModbusUnit unit_;
  ModbusBus& bus_;
  const std::array<std::uint16_t, 4> settings_;  // range, filter, rate divider, accelerometer range
  GyroIdentity identity_;
  double rate_before_hz_ = 0.0;  // of samples, when the unit was opened
  std::optional<Utime> boot_utime_;
  bool begun_ = false;
  int capacity_ = 0;  // of the unit's ring, samples

  std::array<std::uint16_t, kMostWords> words_ = {};
  std::int64_t next_ = 0;    // sample that the unit takes next, unwrapped
  std::int64_t wanted_ = 0;  // sample to be read next
  // Where reading was when the unit was opened again, and how many samples it took until then.
  struct Place {
    std::uint32_t serial_number = 0;
    int boot_count = 0;
    std::uint32_t wanted = 0;
  };
  std::optional<Place> left_off_;
  std::int64_t missed_meanwhile_ = 0;
  std::int64_t tick_ = 0;  // at the last reply, unwrapped
  Utime utime_ = 0;        // of tick_
  std::int64_t last_sample_tick_ = 0;
  Utime last_sample_utime_ = 0;  // kept over a restart: time does not go back

  TickFit fit_;
  std::int64_t tick0_ = 0;  // where the fit counts from
  Utime utime0_ = 0;
  std::int64_t counters_due_tick_ = 0;
  std::array<std::uint32_t, 3> counters_ = {};  // lost, sensor bus errors, frames rejected
};

// Time since the unit's start by its tick, of which only what is left of whole wraps is known: its
// sample number, which wraps much later, tells how many there were. Empty where tick and number do
// not agree (the unit has also sampled at another rate, or sleeps between samples), or after so
// long that they agree with one wrap more as well: then nobody knows.
std::optional<double> SecondsSinceBoot(double tick_s, double tick_wrap_s,
                                       std::int64_t samples_since_boot, double sample_rate_hz);

}  // namespace gyrobench::drivers
