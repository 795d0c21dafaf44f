// The stand's devices as commissioning asks them: on their buses, while nothing else is polled.
#pragma once

#include <functional>
#include <memory>
#include <vector>

#include "commission/probe.h"
#include "config/stand_config.h"
#include "daemon/acquisition.h"
#include "daemon/run_control.h"
#include "drivers/angle_sensor.h"
#include "drivers/axis.h"
#include "drivers/gyro.h"

namespace gyrobench::daemon {

// Holds the acquisition while it lives. Every wait and every move hears of an abort.
class CommissionDevices final : public commission::Devices {
 public:
  struct Context {
    const config::StandConfig& stand;
    Clock& clock;
    Clock::Participant& participant;
    Acquisition& acquisition;
    RunControl& control;
    std::function<void(double fraction, const std::string& axis)> on_progress;
  };
  // Opens the gyro. Throws DeviceError.
  explicit CommissionDevices(Context context);

  int PulsesPerTurn(std::size_t drive) override;
  void StartMove(std::size_t drive, double angle_deg, double rate_deg_s,
                 double acceleration_deg_s2) override;
  bool IsMoving(std::size_t drive) override;
  Angle ReadEncoder(std::size_t encoder) override;
  void ReadRates(std::vector<Rate>* rates) override;
  void Wait(double duration_s) override;
  Utime Now() override { return context_.clock.Now(); }
  void Progress(double fraction, std::size_t drive) override {
    context_.on_progress(fraction, axes_[drive].name);
  }

 private:
  // Nothing is polled while it lives, and outputs are off; each device is opened anew after it.
  class Held {
   public:
    Held(Acquisition& acquisition, Clock::Participant& participant);
    ~Held();
    Held(const Held&) = delete;
    Held& operator=(const Held&) = delete;

   private:
    Acquisition& acquisition_;
    Clock::Participant& participant_;
  };

  void On(const std::string& bus, const std::function<void()>& work);
  // Throws DeviceError where an input of the drive acts, or it cannot turn.
  static void RequireFree(const std::string& axis, const drivers::AxisState& state);

  const Context context_;
  std::vector<config::AxisConfig> axes_;  // with the pulses that the drives say
  const Held held_;
  std::vector<std::unique_ptr<drivers::Axis>> drives_;
  std::vector<std::unique_ptr<drivers::AngleSensor>> encoders_;
  std::unique_ptr<drivers::Gyro> gyro_;
  drivers::GyroIdentity gyro_identity_;
  drivers::GyroBlock block_;
  int boot_count_ = -1;
};

}  // namespace gyrobench::daemon
