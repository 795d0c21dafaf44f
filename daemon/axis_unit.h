// One axis of the stand: its drive and its reference sensor, as they are read and moved.
#pragma once

#include <atomic>
#include <boost/circular_buffer.hpp>
#include <cstdint>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <string>

#include "config/stand_config.h"
#include "daemon/bus_worker.h"
#include "daemon/fault.h"
#include "daemon/motion_guard.h"
#include "daemon/telemetry.h"
#include "drivers/angle_sensor.h"
#include "drivers/axis.h"
#include "drivers/device_maker.h"
#include "gyrobench/angle_t.hpp"

namespace gyrobench::daemon {

// As messages number it.
std::int8_t AxisNumber(const std::string& name);

class AxisUnit {
 public:
  // Told in the threads of the axis's buses.
  struct Hooks {
    std::function<void(Utime)> on_drive_read;  // with the time of its answer
    std::function<void()> stop_all;            // of the whole stand
    // It was found in motion when it was opened, and was told to stop. `not_stopped`: why that
    // failed, empty where it did not.
    std::function<void(const std::string& not_stopped)> on_found_moving;
    FaultHandler on_fault;
  };
  // The buses and the configuration outlive it.
  AxisUnit(const config::AxisConfig& config, BusWorker& drive_bus, BusWorker& encoder_bus,
           drivers::DeviceMaker& devices, Telemetry& telemetry, Hooks hooks);

  const std::string& name() const { return config_.name; }
  const config::AxisConfig& config() const { return config_; }
  BusWorker& drive_bus() const { return drive_bus_; }
  BusWorker& encoder_bus() const { return encoder_bus_; }
  // These belong to the threads of their buses. ReadDrive and ReadEncoder send what they read on.
  // An alarm of the drive and a table beyond its soft limits are faults; the latter stops all. A
  // drive that is no longer enabled is to be opened again (MustBeOpenedAgain): it had lost its power,
  // and with it its count of pulses.
  drivers::Axis& drive() { return *drive_; }
  // A drive that moves is stopped before anything else is asked of it, and it is told: nobody knows
  // who commanded it, and where.
  void OpenDrive();
  void OpenEncoder();
  void ReadDrive();
  void ReadEncoder();
  // As drivers::Axis::MoveBy. Each poll and reading is judged by a MotionGuard: what it finds is a
  // fault, and all is stopped.
  double MoveBy(double angle_deg, double rate_deg_s, double acceleration_deg_s2);

  // By somebody else: what was known of its motion is not held against it.
  void MayHaveBeenTurned();

  // From any thread.
  AxisView view() const;
  LastSamples::Axis last() const;
  // A run turns it: its reference is read at the full rate, and its soft limits hold.
  void SetActive(bool active) {
    if (active) Rearm();
    active_ = active;
  }
  // A table that is still beyond its soft limits, or an emergency stop that still acts, is told
  // once more.
  void Rearm() { beyond_limit_ = emergency_stop_told_ = false; }
  bool active() const { return active_; }
  // Whether the drive answered when it was asked last.
  bool drive_answers() const { return drive_answers_; }
  // How often it was found not enabled when it was opened: it had lost its power, or somebody pressed
  // its emergency stop.
  int power_losses() const { return power_losses_; }
  // Between two readings of the reference.
  Utime encoder_period() const;

 private:
  void StopIfMoving();
  drivers::AxisState AskDrive();
  void Trip(const std::optional<Fault>& fault);
  void CheckSoftLimits(double angle_deg);
  void CheckInputs(const drivers::AxisState& state);

  const config::AxisConfig& config_;
  BusWorker& drive_bus_;
  BusWorker& encoder_bus_;
  Telemetry& telemetry_;
  const Hooks hooks_;
  const std::unique_ptr<drivers::Axis> drive_;
  const std::unique_ptr<drivers::AngleSensor> encoder_;
  std::atomic<bool> active_ = false;
  std::atomic<bool> drive_answers_ = false;
  std::atomic<int> power_losses_ = 0;
  std::atomic<bool> beyond_limit_ = false, emergency_stop_told_ = false;  // reported already
  bool at_limit_ = false;  // of the drive's bus thread: so was its drive at the poll before

  MotionGuard guard_;

  // Of the encoder's bus thread.
  angle_t message_;

  mutable std::mutex mutex_;  // guards what follows
  AxisView view_;
  boost::circular_buffer<drivers::AngleReading> last_;
};

}  // namespace gyrobench::daemon
