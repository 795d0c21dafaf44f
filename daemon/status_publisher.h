// Full state on _STATUS, once a second of bench time and on change; and the care of the record on
// disk: its safety there, and the room for it, without which a run ends.
#pragma once

#include <atomic>
#include <condition_variable>
#include <memory>
#include <mutex>
#include <string>
#include <thread>

#include "base/clock.h"
#include "config/stand_config.h"
#include "daemon/acquisition.h"
#include "daemon/busy_time.h"
#include "daemon/lcm_publisher.h"
#include "daemon/run_control.h"
#include "daemon/telemetry.h"

namespace gyrobench::daemon {

class StatusPublisher {
 public:
  StatusPublisher(const config::StandConfig& stand, Clock& clock, const Acquisition& acquisition,
                  RunControl& control, Telemetry& telemetry, LcmPublisher& publisher);
  ~StatusPublisher();
  void Start();
  // Bench time stands still from now on, or passes again: while it stands still, the state is
  // published by the wall clock.
  void StandStill(bool still);
  // Publishes soon. From any thread.
  void Changed();
  // For how long its thread has been at one message, in real time; the disk apart, which may take
  // its time. 0 while it waits. From any thread.
  double BusyFor_s() const { return busy_.For_s(); }

 private:
  void Loop();
  void Heartbeat();
  void Publish();
  void CareForRecord();
  std::string WhatToKnow() const;

  const config::StandConfig& stand_;
  Clock& clock_;
  const Acquisition& acquisition_;
  RunControl& control_;
  Telemetry& telemetry_;
  LcmPublisher& publisher_;
  std::unique_ptr<Clock::Participant> participant_;
  std::atomic<bool> stopping_ = false;
  BusyTime busy_;
  std::atomic<bool> still_ = false;
  std::mutex heartbeat_mutex_;
  std::condition_variable heartbeat_ends_;
  Utime last_utime_ = 0;
  std::int64_t last_samples_ = 0;
  double gyro_rate_hz_ = 0.0;
  std::thread thread_;
  std::thread heartbeat_;
};

}  // namespace gyrobench::daemon
