// The narrow interface of the gyro unit: a microcontroller that samples a MEMS gyro into a ring.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "base/clock.h"

namespace gyrobench::drivers {

// Who answers, and with which settings.
struct GyroIdentity {
  std::uint32_t serial_number = 0;
  int protocol_version = 0;
  std::string firmware;  // "1.4"
  int boot_count = 0;
  double tick_rate_hz = 0.0;        // nominal
  double sample_rate_hz = 0.0;      // nominal
  double gyro_lsb_per_deg_s = 0.0;  // nominal, of the range in force
  double accel_lsb_per_g = 0.0;
  double filter_bandwidth_hz = 0.0;
  double filter_delay_s = 0.0;  // nominal group delay, data sheet
};

// One sample as the sensor gave it, coherent over its channels.
struct GyroRawSample {
  std::int64_t counter = 0;  // sample number since boot, unwrapped
  std::int64_t tick = 0;     // microcontroller's tick, unwrapped
  Utime utime = 0;           // host time of the tick, by the fit so far
  std::array<std::int16_t, 3> gyro_lsb = {};
  std::array<std::int16_t, 3> accel_lsb = {};
  double temperature_degC = 0.0;
};

// What one read brought. `samples` is empty when nothing new was there.
struct GyroBlock {
  Utime utime = 0;        // host time at which the unit took `tick`
  std::int64_t tick = 0;  // unit's tick at the read, unwrapped
  int boot_count = 0;
  // Host time at which the unit started, as its tick told when it was opened (nominal rate, so
  // that it errs by that of the tick). Empty where the tick may have wrapped since.
  std::optional<Utime> boot_utime;
  std::int64_t missed =
      0;  // samples that were overwritten before they were read, since the last block
  std::uint32_t sensor_bus_errors = 0;  // counters of the unit since its boot
  std::uint32_t samples_lost = 0;
  std::uint32_t frames_rejected = 0;
  std::vector<GyroRawSample> samples;
};

// Calls throw DeviceError and belong to the thread of the bus.
class Gyro {
 public:
  virtual ~Gyro() = default;
  virtual const std::string& name() const = 0;
  // Checks identity and protocol, writes range, filter and rate of the configuration, reads them
  // back.
  virtual GyroIdentity Open() = 0;
  // Reads the samples since the last read into `block`, whose memory is used again. One request in
  // the common case; more while the ring holds more than a reply does.
  virtual void Read(GyroBlock& block) = 0;
};

}  // namespace gyrobench::drivers
