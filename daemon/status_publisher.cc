#include "daemon/status_publisher.h"

#include <chrono>

#include "base/version.h"
#include "daemon/disk_room.h"
#include "gyrobench/status_t.hpp"

namespace gyrobench::daemon {

StatusPublisher::StatusPublisher(const config::StandConfig& stand, Clock& clock,
                                 const Acquisition& acquisition, RunControl& control,
                                 Telemetry& telemetry, LcmPublisher& publisher)
    : stand_(stand),
      clock_(clock),
      acquisition_(acquisition),
      control_(control),
      telemetry_(telemetry),
      publisher_(publisher),
      participant_(clock.Join("status")),
      last_utime_(clock.Now()) {}

StatusPublisher::~StatusPublisher() {
  {
    const std::lock_guard lock(heartbeat_mutex_);
    stopping_ = true;
  }
  heartbeat_ends_.notify_all();
  if (heartbeat_.joinable()) heartbeat_.join();
  participant_->Notify();
  if (thread_.joinable()) thread_.join();
}

void StatusPublisher::Start() {
  thread_ = std::thread([this] { Loop(); });
  if (stand_.virtual_stand) heartbeat_ = std::thread([this] { Heartbeat(); });
}

void StatusPublisher::StandStill(bool still) {
  still_ = still;
  Changed();
}

void StatusPublisher::Heartbeat() {
  std::unique_lock lock(heartbeat_mutex_);
  while (!heartbeat_ends_.wait_for(lock, std::chrono::seconds(1), [this] { return !!stopping_; })) {
    if (still_) Changed();
  }
}

void StatusPublisher::Changed() { participant_->Notify(); }

void StatusPublisher::Loop() {
  // The disk lives in real time, whatever the bench's clock does.
  auto last_sync = std::chrono::steady_clock::now();
  while (!stopping_) {
    {
      const BusyTime::While busy(busy_);
      publisher_.Open();
      Publish();
    }
    const auto now = std::chrono::steady_clock::now();
    if (now - last_sync >= std::chrono::seconds(1)) {
      CareForRecord();
      last_sync = now;
    }
    participant_->WaitUntil(still_ ? kForever : clock_.Now() + kMicrosecondsPerSecond);
  }
}

void StatusPublisher::CareForRecord() {
  telemetry_.Sync();
  if (!control_.run_is_on()) return;
  const std::string low = WhyNoRoom(stand_.records, stand_.safety.min_free_mib);
  if (!low.empty()) control_.Report({"record", low});
}

std::string StatusPublisher::WhatToKnow() const {
  if (const auto fault = control_.fault()) return TextOf(*fault);
  for (const DeviceStatus& device : acquisition_.Devices()) {
    if (!device.ok) return WithSource(device.name, device.message);
  }
  return publisher_.health();
}

void StatusPublisher::Publish() {
  const SensorView sensor = acquisition_.Sensor();
  const Utime now = clock_.Now();
  status_t message{};
  message.utime = now;
  message.state = static_cast<std::int8_t>(control_.state());
  message.stand = stand_.name;
  message.version = kVersion;
  message.virtual_stand = stand_.virtual_stand.has_value();
  message.temperature_degC = sensor.temperature_degC;
  message.tick_ratio = sensor.tick_ratio;
  const double elapsed_s = ToSeconds(now - last_utime_);
  if (elapsed_s > 0) {
    gyro_rate_hz_ = static_cast<double>(sensor.samples - last_samples_) / elapsed_s;
  }
  message.gyro_rate_hz = gyro_rate_hz_;
  last_utime_ = now;
  last_samples_ = sensor.samples;
  message.message = WhatToKnow();
  telemetry_.Send(message);
}

static_assert(status_t::IDLE == static_cast<std::int8_t>(State::kIdle));
static_assert(status_t::RUNNING == static_cast<std::int8_t>(State::kRunning));
static_assert(status_t::PAUSED == static_cast<std::int8_t>(State::kPaused));
static_assert(status_t::ASKING == static_cast<std::int8_t>(State::kAsking));
static_assert(status_t::STOPPING == static_cast<std::int8_t>(State::kStopping));
static_assert(status_t::FAULT == static_cast<std::int8_t>(State::kFault));
static_assert(status_t::PAUSING == static_cast<std::int8_t>(State::kPausing));
static_assert(status_t::DISCONNECTED == static_cast<std::int8_t>(State::kDisconnected));
static_assert(status_t::PREPARING == static_cast<std::int8_t>(State::kPreparing));
static_assert(status_t::SUSPENDED == static_cast<std::int8_t>(State::kSuspended));

}  // namespace gyrobench::daemon
