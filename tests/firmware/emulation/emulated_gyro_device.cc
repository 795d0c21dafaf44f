#include "tests/firmware/emulation/emulated_gyro_device.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace gyrobench::firmware {
namespace {

// Bytes of the request's frame beside the registers that it writes.
constexpr std::size_t kReadFrame = 8, kWriteFrame = 9;
// A request begins so long before the device has it: 250 bytes at 115200 baud.
constexpr double kLongestFrame_s = 0.025;

}  // namespace

EmulatedGyroDevice::EmulatedGyroDevice(const std::filesystem::path& image,
                                       const config::GyroUnitMap& map, stand::Physics& physics,
                                       Utime start)
    : Device("gyro"),
      map_(map),
      physics_(physics),
      start_(start),
      sensor_([this](double t_s, const auto& settings) { return Sample(t_s, settings); },
              physics.specimen().gyro.sample_clock_rel),
      unit_(image, sensor_, physics.specimen().unit.tick_rel),
      master_(unit_) {}

// The physics sample as the sensor does: by its clock from when it was set.
VirtualMpu6050::Words EmulatedGyroDevice::Sample(double t_s,
                                                 const VirtualMpu6050::Settings& settings) {
  const auto set = [&](stand::GyroSampler& gyro, double) {
    const double clock = 1.0 + physics_.specimen().gyro.sample_clock_rel;
    const int divider = static_cast<int>(std::lround(1000.0 * clock / settings.rate_hz)) - 1;
    gyro.Set(t_s, {.range = settings.gyro_range,
                   .filter = settings.filter,
                   .divider = divider,
                   .accel_range = settings.accel_range});
    next_ = gyro.next_number();
  };
  if (!set_ || settings != settings_) {
    physics_.WithGyro(At(t_s), set);
    settings_ = settings;
    set_ = true;
    return {};
  }
  const std::uint32_t wanted = next_++;
  VirtualMpu6050::Words words = {};
  // A microsecond on: the sample is there at its time, which is not a whole one.
  physics_.WithGyro(At(t_s) + 1 + FromSeconds(physics_.specimen().unit.tick_jitter_s),
                    [&](const stand::GyroSampler& gyro, double) {
                      const std::uint32_t at =
                          std::clamp(wanted, gyro.oldest_number(), gyro.next_number() - 1);
                      if (gyro.next_number() > gyro.oldest_number()) words = gyro.sample(at).words;
                    });
  return words;
}

stand::ModbusException EmulatedGyroDevice::Read(int function, std::uint16_t address,
                                                std::span<std::uint16_t> words, Utime at) {
  const std::lock_guard lock(mutex_);
  master_.WaitToComplete(kReadFrame, ToSeconds(at - start_));
  const auto reply = master_.Read(function, address, static_cast<int>(words.size()));
  if (!reply || (reply->exception == 0 && reply->words.size() != words.size()))
    return stand::ModbusException::kDeviceFailure;
  std::ranges::copy(reply->words, words.begin());
  return static_cast<stand::ModbusException>(reply->exception);
}

stand::ModbusException EmulatedGyroDevice::Write(std::uint16_t address,
                                                 std::span<const std::uint16_t> words, Utime at) {
  const std::lock_guard lock(mutex_);
  master_.WaitToComplete(kWriteFrame + 2 * words.size(), ToSeconds(at - start_));
  const auto reply = master_.WriteMany(address, words);
  return reply ? static_cast<stand::ModbusException>(reply->exception)
               : stand::ModbusException::kDeviceFailure;
}

void EmulatedGyroDevice::CatchUp(Utime now) {
  const std::lock_guard lock(mutex_);
  const double t_s = ToSeconds(now - start_) - kLongestFrame_s;
  if (t_s > unit_.now_s()) unit_.RunUntil(t_s);
}

stand::ModbusException EmulatedGyroDevice::Disguise(std::uint16_t address,
                                                    std::span<std::uint16_t> words) {
  const std::size_t magic = static_cast<std::uint16_t>(map_.identity_address - address);
  if (magic < words.size()) words[magic] = 0x1234;
  return stand::ModbusException::kNone;
}

}  // namespace gyrobench::firmware
