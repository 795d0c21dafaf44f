// A Modbus device of the virtual stand, register by register.
#pragma once

#include <cstdint>
#include <span>
#include <string>

#include "base/clock.h"

namespace gyrobench::stand {

enum class ModbusException : std::uint8_t {
  kNone = 0,
  kIllegalFunction = 1,
  kIllegalAddress = 2,
  kIllegalValue = 3,
  kDeviceFailure = 4,
};

// Calls come from the thread of the device's bus. `at`: when the device took the request.
class Device {
 public:
  explicit Device(std::string name) : name_(std::move(name)) {}
  virtual ~Device() = default;
  Device(const Device&) = delete;
  Device& operator=(const Device&) = delete;

  // "gyro", "inner.drive", "inner.encoder", "relays".
  const std::string& name() const { return name_; }
  // Function 3 or 4: fills `words` from `address` on.
  virtual ModbusException Read(int function, std::uint16_t address, std::span<std::uint16_t> words,
                               Utime at) = 0;
  // Functions 6 and 16.
  virtual ModbusException Write(std::uint16_t address, std::span<const std::uint16_t> words,
                                Utime at) = 0;
  // Function 1: fills `coils` from `address` on.
  virtual ModbusException ReadCoils(std::uint16_t /*address*/, std::span<bool> /*coils*/) {
    return ModbusException::kIllegalFunction;
  }
  // Function 5.
  virtual ModbusException WriteCoil(std::uint16_t /*address*/, bool /*on*/, Utime /*at*/) {
    return ModbusException::kIllegalFunction;
  }
  // What another device in its place would have answered; spoils what tells who it is.
  virtual ModbusException Disguise(std::uint16_t address, std::span<std::uint16_t> words) = 0;
  // It was without power for an instant before `at`.
  virtual void LosePower(Utime /*at*/) {}
  // A frame with a wrong checksum was on the line.
  virtual void FrameRejected() {}

 private:
  std::string name_;
};

constexpr std::uint16_t High(std::uint32_t value) {
  return static_cast<std::uint16_t>(value >> 16U);
}
constexpr std::uint16_t Low(std::uint32_t value) {
  return static_cast<std::uint16_t>(value & 0xFFFFU);
}

}  // namespace gyrobench::stand
