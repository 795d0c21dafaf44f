#include "tests/firmware/emulation/virtual_mpu6050.h"

#include <cmath>

namespace gyrobench::firmware {
namespace {

constexpr std::size_t kSampleRateDivider = 0x19, kConfig = 0x1A, kGyroConfig = 0x1B,
                      kAccelConfig = 0x1C, kInterruptEnable = 0x38, kFirstData = 0x3B,
                      kPowerManagement1 = 0x6B, kWhoAmI = 0x75;
constexpr std::uint8_t kSleep = 0x40, kDeviceReset = 0x80, kDataReady = 0x01;

}  // namespace

std::array<std::uint8_t, 128> VirtualMpu6050::PowerOnRegisters() {
  std::array<std::uint8_t, 128> registers = {};
  registers[kPowerManagement1] = kSleep;
  return registers;
}

void VirtualMpu6050::Reset() {
  registers_ = PowerOnRegisters();
  next_s_.reset();
}

void VirtualMpu6050::SetPresent(bool present) {
  if (present && !present_) Reset();
  present_ = present;
  if (!present) next_s_.reset();
}

VirtualMpu6050::Settings VirtualMpu6050::settings() const {
  return {.gyro_range = registers_[kGyroConfig] >> 3 & 3,
          .accel_range = registers_[kAccelConfig] >> 3 & 3,
          .filter = registers_[kConfig] & 7,
          .rate_hz = 1.0 / Period_s()};
}

double VirtualMpu6050::Period_s() const {
  const int filter = registers_[kConfig] & 7;
  const double output_hz = filter == 0 || filter == 7 ? 8000.0 : 1000.0;
  return (1 + registers_[kSampleRateDivider]) / (output_hz * (1.0 + clock_rel_));
}

void VirtualMpu6050::Schedule(double now_s) {
  const bool samples = (registers_[kPowerManagement1] & kSleep) == 0 &&
                       (registers_[kInterruptEnable] & kDataReady) != 0;
  if (samples) {
    next_s_ = now_s + Period_s();
  } else {
    next_s_.reset();
  }
}

void VirtualMpu6050::Write(std::uint8_t byte, double now_s) {
  if (!pointer_given_) {
    pointer_ = byte & 0x7F;
    pointer_given_ = true;
    return;
  }
  const std::size_t reg = pointer_;
  pointer_ = (pointer_ + 1) & 0x7F;
  registers_[reg] = byte;
  if (reg == kPowerManagement1 && (byte & kDeviceReset) != 0) {
    Reset();
  } else if (reg == kPowerManagement1 || reg == kSampleRateDivider || reg == kConfig ||
             reg == kInterruptEnable) {
    Schedule(now_s);
  }
}

std::uint8_t VirtualMpu6050::Read() {
  const std::size_t reg = pointer_;
  pointer_ = (pointer_ + 1) & 0x7F;
  return reg == kWhoAmI ? who_am_i_ : registers_[reg];
}

void VirtualMpu6050::MakeReady() {
  const double t_s = *next_s_;
  const Words words = source_(t_s, settings());
  for (std::size_t i = 0; i < words.size(); ++i) {
    const auto value = static_cast<std::uint16_t>(words[i]);
    registers_[kFirstData + 2 * i] = static_cast<std::uint8_t>(value >> 8);
    registers_[kFirstData + 2 * i + 1] = static_cast<std::uint8_t>(value & 0xFF);
  }
  next_s_ = t_s + Period_s();
}

}  // namespace gyrobench::firmware
