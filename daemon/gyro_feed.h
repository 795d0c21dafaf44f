// The gyro unit at work: its blocks read, its clock compared with the host's, its samples sent on.
#pragma once

#include <atomic>
#include <boost/circular_buffer.hpp>
#include <cstdint>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <vector>

#include "base/clock.h"
#include "base/tick_fit.h"
#include "config/stand_config.h"
#include "daemon/power_on.h"
#include "daemon/telemetry.h"
#include "drivers/gyro.h"
#include "gyrobench/gyro_t.hpp"

namespace gyrobench::daemon {

// What is known of the sensor now.
struct SensorView {
  drivers::GyroIdentity identity;
  double temperature_degC = kMissing;
  double tick_ratio = kMissing;
  double tick_span_s = 0.0;         // that the tick's fit rests on
  std::int64_t samples = 0;         // since the daemon started
  int starts = 0;                   // of the unit that were seen, the first included
  std::int64_t missed = 0;          // the same: overwritten before they were read
  std::optional<PowerOn> power_on;  // empty where it is not known
};

class GyroFeed {
 public:
  // `on_temperature` is told, in the bus's thread, what the thermometer of each block's last sample
  // says. All must outlive it.
  GyroFeed(const config::GyroConfig& config, double silence_s, const Clock& clock,
           std::unique_ptr<drivers::Gyro> gyro, Telemetry& telemetry,
           std::function<void(double temperature_degC)> on_temperature);

  // Both belong to the thread of the bus and throw DeviceError; Read also where the unit answers,
  // but has had no sample of its sensor for longer than `silence_s`.
  void Open();
  void Read();
  // Between two blocks.
  Utime period() const;

  // From any thread.
  SensorView view() const;
  // When the newest sample was taken that has come [host time]; 0 where none has.
  Utime newest_sample() const { return newest_sample_; }
  std::vector<drivers::GyroRawSample> last() const;

 private:
  void CompareClocks();
  void RequireSamples();

  const config::GyroConfig& config_;
  const double silence_s_;
  const Clock& clock_;
  const std::unique_ptr<drivers::Gyro> gyro_;
  Telemetry& telemetry_;
  const std::function<void(double)> on_temperature_;

  // Of the bus's thread.
  drivers::GyroBlock block_;
  gyro_t message_;
  PowerOnWatch power_on_watch_;
  TickFit tick_fit_;
  int boot_count_ = 0;
  int starts_ = 0;
  Utime last_sample_ = 0;  // when one came, or the unit was opened
  double first_tick_s_ = 0.0;
  double last_tick_s_ = 0.0;

  std::atomic<Utime> newest_sample_ = 0;
  mutable std::mutex mutex_;  // guards what follows; the identity is written by the bus's thread
  SensorView view_;
  boost::circular_buffer<drivers::GyroRawSample> last_;
};

}  // namespace gyrobench::daemon
