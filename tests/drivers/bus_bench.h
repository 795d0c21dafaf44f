// A line with one unit, and the bus that asks it.
#pragma once

#include <gmock/gmock.h>

#include <array>
#include <cstdint>
#include <memory>
#include <string>

#include "base/error.h"
#include "drivers/modbus_bus.h"
#include "tests/drivers/fake_line.h"
#include "tests/drivers/manual_clock.h"

namespace gyrobench::drivers {

inline constexpr Utime kTimeout_us = 100'000;
inline const ModbusUnit kUnit = {"axis.inner drive", 5};

// A line of one transport with a unit 5 whose registers all differ, and a bus with one retry.
class BusBench {
 public:
  explicit BusBench(Transport transport, int retries = 1) : line(transport) {
    unit.SetHolding(0x1003, {0x1111, 0x2222, 0x3333});
    unit.SetInput(0x1003, {0x4444, 0x5555, 0x6666});
    line.Connect(kUnit.unit, unit);
    line.SetDelay([this](Utime duration_us) { clock.Advance(duration_us); });
    config::BusConfig config = line.Config();
    config.retries = retries;
    bus = std::make_unique<ModbusBus>(config, clock, *participant);
  }

  std::array<std::uint16_t, 3> Read() {
    std::array<std::uint16_t, 3> values = {};
    timing = bus->ReadHolding(kUnit, 0x1003, values, "status");
    return values;
  }
  // What the DeviceError of the next read says; empty when there is none.
  std::string ReadFailure() {
    try {
      Read();
    } catch (const DeviceError& error) {
      return error.what();
    }
    return "";
  }

  ManualClock clock;
  std::unique_ptr<Clock::Participant> participant = clock.Join("bus A", Clock::Role::kResident);
  RegisterUnit unit;
  FakeLine line;
  std::unique_ptr<ModbusBus> bus;
  Timing timing;
};

// What it reads.
inline const auto kGood = testing::ElementsAre(0x1111, 0x2222, 0x3333);

}  // namespace gyrobench::drivers
