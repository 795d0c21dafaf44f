#include "tests/daemon/resting_gyro.h"

#include "daemon/messages.h"
#include "gyrobench/gyro_t.hpp"

namespace gyrobench::daemon {

MeasurementInfo RestingGyro::Info() {
  MeasurementInfo info;
  info.gyro_present = info.accel_present = {true, true, true};
  info.gyro_units_per_deg_s = 131.0;
  info.temperature_present = true;
  info.reference = ReferenceKind::kNone;
  return info;
}

void RestingGyro::SendTo(Telemetry& telemetry, double duration_s, int lsb) {
  constexpr Utime kStep = 10'000;
  constexpr int kSamples = 10;  // of a message
  constexpr std::int64_t kTicksPerSample = 625;
  drivers::GyroIdentity identity;
  identity.tick_rate_hz = 62500.0;
  identity.gyro_lsb_per_deg_s = 131.0;
  identity.accel_lsb_per_g = 16384.0;
  for (int sent = 0; sent < static_cast<int>(duration_s * 10.0); ++sent) {
    drivers::GyroBlock block;
    for (int i = 0; i < kSamples; ++i) {
      utime_ += kStep;
      const auto shown = static_cast<std::int16_t>(lsb + counter_ % 3 - 1);
      block.samples.push_back({counter_,
                               counter_ * kTicksPerSample,
                               utime_,
                               {shown, shown, shown},
                               {0, 0, 16384},
                               25.0});
      ++counter_;
    }
    block.utime = utime_;
    block.tick = counter_ * kTicksPerSample;
    gyro_t message{};
    FillMessage(block, identity, message);
    telemetry.Send(message);
  }
}

}  // namespace gyrobench::daemon
