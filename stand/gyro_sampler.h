// The gyro unit's sampling: truth of the stand in, raw samples in a ring out.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "config/device_maps.h"
#include "config/scenario.h"
#include "stand/accelerometer.h"
#include "stand/faults.h"
#include "stand/geometry.h"
#include "stand/gyro_model.h"
#include "stand/gyro_noise.h"
#include "stand/low_pass.h"
#include "stand/mechanics.h"
#include "stand/thermal.h"
#include "stand/unit_clock.h"

namespace gyrobench::stand {

// Settings as the unit's registers hold them (docs of the gyro unit).
struct GyroSettings {
  int range = 0;
  int filter = 3;
  int divider = 4;  // 200 Hz
  int accel_range = 0;
};

struct RawSample {
  std::uint32_t tick = 0;
  // Accelerometer x, y, z, temperature, gyro x, y, z.
  std::array<std::int16_t, 7> words = {};
};

// Samples are made lazily, up to the time that is asked for, one after the other: what they are
// does not depend on when they are asked for. The sensor's clock sets the sample instants; the true
// rate of each instant is the mean over the chip's internal step (1 ms), from differences of the
// true angles, so that the sum of the rates is the angle, put through the filter. Keeps references
// to the scenario's parts.
class GyroSampler {
 public:
  static constexpr std::size_t kCapacity = 64;

  GyroSampler(const config::Scenario& specimen, const config::GyroUnitMap& map, std::uint64_t seed,
              const Geometry& geometry, const Faults& faults);

  // Makes the samples that are ready at `t_s`.
  void CatchUp(double t_s, const std::array<AxisMechanics, 3>& axes);
  // In force from `t_s` on; the ring is emptied, numbers go on.
  void Set(double t_s, const GyroSettings& settings);
  // The unit restarts: settings, clock and numbers begin anew.
  void Reboot(double t_s);
  void JumpClock(double s) { clock_.Jump(s); }
  void SetTemperature(double degC) { thermal_.SetTemperature(degC); }
  void SetFan(bool blows) { thermal_.SetFan(blows); }
  void SetHeater(bool heats) { thermal_.SetHeater(heats); }

  const GyroSettings& settings() const { return settings_; }
  std::uint32_t next_number() const { return next_number_; }
  std::uint32_t oldest_number() const { return next_number_ - held_; }
  const RawSample& sample(std::uint32_t number) const { return ring_[number % kCapacity]; }
  std::uint32_t TickAt(double t_s) const { return clock_.TickAt(t_s); }
  int boot_count() const { return boot_count_; }
  std::uint32_t samples_lost() const { return samples_lost_; }
  double sample_rate_hz() const { return 1000.0 / (1 + settings_.divider); }
  const Thermal& thermal() const { return thermal_; }

 private:
  void Configure();
  void Take(const std::array<AxisMechanics, 3>& axes);
  void Follow(double truth_s, const std::array<AxisMechanics, 3>& axes);
  void FollowMotion(double step_s, int steps, const std::array<AxisMechanics, 3>& axes);
  void FilterStep(const Triple& rate_deg_s);
  void Store(const std::array<std::int16_t, 7>& words);
  std::array<std::int16_t, 7> Convert(const std::array<AxisMechanics, 3>& axes);
  void Spoil(std::array<std::int16_t, 7>& words) const;

  const config::Scenario& specimen_;
  const config::GyroUnitMap& map_;
  const Faults& faults_;
  GyroSettings settings_;
  double step_s_;    // the sensor's internal step
  double period_s_;  // of the samples
  double lsb_per_deg_s_ = 0.0, lsb_per_g_ = 0.0;

  Geometry geometry_;
  Thermal thermal_;
  GyroModel model_;
  GyroNoise noise_;
  Accelerometer accelerometer_;
  RandomStream thermometer_, jitter_, loss_;
  UnitClock clock_;
  LowPass extra_lag_, filter_;
  bool has_extra_lag_;
  int rest_steps_ = 0;
  double rest_fraction_ = 0.0;

  double truth_s_ = 0.0;  // up to here the truth went through the filter
  Triple angles_deg_ = {};
  bool angles_known_ = false;
  Triple gravity_g_ = {}, rest_rate_deg_s_ = {};

  double next_s_ = 0.0;
  std::uint32_t next_number_ = 0;
  std::uint32_t held_ = 0;
  int boot_count_;
  std::uint32_t samples_lost_ = 0;
  std::array<RawSample, kCapacity> ring_;
};

}  // namespace gyrobench::stand
