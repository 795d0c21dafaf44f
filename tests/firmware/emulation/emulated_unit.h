// The gyro unit's image, instruction by instruction, with a virtual sensor on its bus.
#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <span>
#include <vector>

#include "tests/firmware/emulation/virtual_mpu6050.h"

namespace gyrobench::firmware {

// An ATmega328P by simavr. simavr 1.6 has two faults in its two-wire bus, which are mended from
// outside: TWINT stays where it is written, and an address that is taken is reported as a byte that
// is taken; and it gives a character of 8N1 eleven bits. The two-wire bus is quicker than a real
// one: its speed cannot be judged here. Time is that of the bench, in seconds since power-on.
class EmulatedUnit {
 public:
  struct Byte {
    std::uint8_t value = 0;
    double end_s = 0.0;  // of its stop bit
  };

  // `resonator_rel`: the processor runs so much too fast. The sensor must outlive the unit. Throws
  // std::runtime_error where the image cannot be read.
  EmulatedUnit(const std::filesystem::path& elf, VirtualMpu6050& sensor,
               double resonator_rel = 0.0);
  ~EmulatedUnit();
  EmulatedUnit(const EmulatedUnit&) = delete;
  EmulatedUnit& operator=(const EmulatedUnit&) = delete;

  double now_s() const;
  // Throws std::runtime_error where the processor has stopped or crashed.
  void RunUntil(double t_s);
  // Puts the bytes on the line, one behind the other from now on.
  void Send(std::span<const std::uint8_t> bytes, int baud);
  // What the unit has sent since the last call.
  std::vector<Byte> TakeSent();
  // The reset button. What the EEPROM holds stays.
  void Reset();
  // The pin that asks for the line's defaults, to ground or open.
  void SetDefaultsPin(bool to_ground);
  // The sensor holds SDA low until it has been clocked so many times.
  void HoldSda(int clocks);
  // Bytes of memory that the stack has never reached.
  std::size_t StackLeft() const;
  // Whether the transceiver is switched to sending.
  bool sends() const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace gyrobench::firmware
