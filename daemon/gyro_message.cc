#include "daemon/gyro_message.h"

namespace gyrobench::daemon {

void FillMessage(const drivers::GyroBlock& block, const drivers::GyroIdentity& identity,
                 gyro_t& message) {
  const std::size_t n = block.samples.size();
  message.utime = block.utime;
  message.unit_tick = block.tick;
  message.tick_rate_hz = identity.tick_rate_hz;
  message.boot_count = block.boot_count;
  message.missed = block.missed;
  message.gyro_lsb_per_deg_s = identity.gyro_lsb_per_deg_s;
  message.accel_lsb_per_g = identity.accel_lsb_per_g;
  message.n = static_cast<std::int32_t>(n);
  message.first_counter = n == 0 ? 0 : block.samples.front().counter;
  message.sample_utime.resize(n);
  message.sample_tick.resize(n);
  message.temperature_degC.resize(n);
  message.gyro_lsb.resize(3);
  message.accel_lsb.resize(3);
  for (std::size_t axis = 0; axis < 3; ++axis) {
    message.gyro_lsb[axis].resize(n);
    message.accel_lsb[axis].resize(n);
  }
  for (std::size_t i = 0; i < n; ++i) {
    const drivers::GyroRawSample& sample = block.samples[i];
    message.sample_utime[i] = sample.utime;
    message.sample_tick[i] = sample.tick;
    message.temperature_degC[i] = static_cast<float>(sample.temperature_degC);
    for (std::size_t axis = 0; axis < 3; ++axis) {
      message.gyro_lsb[axis][i] = sample.gyro_lsb[axis];
      message.accel_lsb[axis][i] = sample.accel_lsb[axis];
    }
  }
}

}  // namespace gyrobench::daemon
