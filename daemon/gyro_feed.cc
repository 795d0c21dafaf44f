#include "daemon/gyro_feed.h"

#include <fmt/format.h>

#include <utility>

#include "base/error.h"
#include "daemon/fault.h"
#include "daemon/messages.h"

namespace gyrobench::daemon {

GyroFeed::GyroFeed(const config::GyroConfig& config, double silence_s, const Clock& clock,
                   std::unique_ptr<drivers::Gyro> gyro, Telemetry& telemetry,
                   std::function<void(double)> on_temperature)
    : config_(config),
      silence_s_(silence_s),
      clock_(clock),
      gyro_(std::move(gyro)),
      telemetry_(telemetry),
      on_temperature_(std::move(on_temperature)),
      last_(kLastSamples) {}

// One sample less than a reply carries: a poll that comes a little late still needs one request
// only.
Utime GyroFeed::period() const {
  return FromSeconds(1.0 / (config_.rate_hz / (config_.map.max_samples_per_block - 1)));
}

void GyroFeed::Open() {
  const drivers::GyroIdentity identity = gyro_->Open();
  last_sample_ = clock_.Now();
  const std::lock_guard lock(mutex_);
  view_.identity = identity;
}

void GyroFeed::CompareClocks() {
  const double tick_s = static_cast<double>(block_.tick) / view_.identity.tick_rate_hz;
  const bool began_anew = block_.boot_count != boot_count_ || tick_s < last_tick_s_;
  last_tick_s_ = tick_s;
  if (block_.boot_count != boot_count_) ++starts_;
  if (tick_fit_.count() == 0 || began_anew) {
    tick_fit_ = TickFit();
    boot_count_ = block_.boot_count;
    first_tick_s_ = tick_s;
  }
  tick_fit_.Add({tick_s, ToSeconds(block_.utime)});
}

void GyroFeed::Read() {
  gyro_->Read(block_);
  CompareClocks();
  power_on_watch_.Take(view_.identity.serial_number, block_);
  {
    const std::lock_guard lock(mutex_);
    view_.power_on = power_on_watch_.power_on();
    view_.tick_ratio = tick_fit_.ratio();
    view_.tick_span_s = last_tick_s_ - first_tick_s_;
    view_.samples += static_cast<std::int64_t>(block_.samples.size());
    view_.starts = starts_;
    view_.missed += block_.missed;
    if (!block_.samples.empty()) view_.temperature_degC = block_.samples.back().temperature_degC;
    for (const drivers::GyroRawSample& sample : block_.samples) last_.push_back(sample);
  }
  RequireSamples();
  FillMessage(block_, view_.identity, message_);
  telemetry_.Send(message_);
  if (!block_.samples.empty()) newest_sample_ = block_.samples.back().utime;
}

// A unit that answers while its sensor is silent would leave a run blind, and a heater unwatched.
void GyroFeed::RequireSamples() {
  if (!block_.samples.empty()) {
    last_sample_ = clock_.Now();
    on_temperature_(block_.samples.back().temperature_degC);
    return;
  }
  const double silent_s = ToSeconds(clock_.Now() - last_sample_);
  if (silent_s <= silence_s_) return;
  throw DeviceError(
      fmt::format("gyro: the unit answers, but has had no sample of its sensor for {:.1f} s, "
                  "expected {:g} Hz. Check the sensor's own bus and supply.",
                  silent_s, config_.rate_hz),
      {.device = "gyro", .action = "samples"});
}

SensorView GyroFeed::view() const {
  const std::lock_guard lock(mutex_);
  return view_;
}

std::vector<drivers::GyroRawSample> GyroFeed::last() const {
  const std::lock_guard lock(mutex_);
  return {last_.begin(), last_.end()};
}

}  // namespace gyrobench::daemon
