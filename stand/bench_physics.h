// The physics of the whole bench: three axes, their encoders, the gyro unit.
#pragma once

#include <array>
#include <cstdint>
#include <mutex>
#include <optional>
#include <utility>
#include <vector>

#include "base/clock.h"
#include "config/scenario.h"
#include "config/stand_config.h"
#include "stand/angle_encoder.h"
#include "stand/faults.h"
#include "stand/geometry.h"
#include "stand/gyro_sampler.h"
#include "stand/mechanics.h"
#include "stand/truth_log.h"

namespace gyrobench::stand {

// Deterministic for a specimen and a seed: what is read depends on the commands and their times,
// not on who reads what how often. Calls may come from several threads; times may lag behind an
// earlier call's (two buses), a command then counts from the latest time at which the gyro was
// sampled.
class Physics {
 public:
  struct DriveView {
    std::int64_t pulses = 0;
    bool moving = false;
    int alarm = 0;
    bool emergency_stop = false, limit_plus = false, limit_minus = false;  // inputs that act
  };

  // `specimen`: see DrawSpecimen. `seed`: of the noise. Power-on is at `start`.
  // Throws ConfigError where the stand file's gyro map lacks the sensor's ranges or filters, or its
  // truth file cannot be written.
  Physics(const config::StandConfig& stand, const config::Scenario& specimen, std::uint64_t seed,
          Utime start);
  Physics(const Physics&) = delete;
  Physics& operator=(const Physics&) = delete;

  // Everything up to `at` happens. Reading does it by itself.
  void AdvanceTo(Utime at);

  // `axis`: StandAxis as an index. The target is relative to where the command count is.
  void MoveBy(std::size_t axis, Utime at, std::int64_t pulses, MoveCommand command);
  void MoveTo(std::size_t axis, Utime at, MoveCommand command);
  void QuickStop(std::size_t axis, Utime at);
  void ClearAlarm(std::size_t axis, Utime at);
  DriveView Drive(std::size_t axis, Utime at);
  std::uint32_t EncoderCounts(std::size_t axis, Utime at);

  // The gyro unit as it is at `at`: `use(GyroSampler&, seconds since power-on)`.
  template <class Use>
  auto WithGyro(Utime at, Use&& use) {
    const std::lock_guard lock(mutex_);
    const double t_s = Advance(at);
    return std::forward<Use>(use)(gyro_, t_s);
  }
  // Someone brings the unit to another temperature and puts it back.
  void SetTemperature(Utime at, double degC);
  void SetFan(Utime at, bool blows);
  void SetHeater(Utime at, bool heats);

  // What only tests and the scenario's author may know.
  AxisTruth Truth(std::size_t axis, Utime at);
  const config::Scenario& specimen() const { return specimen_; }
  Faults& faults() { return faults_; }

 private:
  struct AxisConstants {
    double gear_ratio = 40.0;
    double pulses_per_turn = 10000.0;
    config::EncoderConfig encoder;
  };

  static AxisConstants ConstantsOf(const config::StandConfig& stand, std::size_t axis);
  AxisMechanics MakeAxis(std::size_t axis) const;
  AngleEncoder MakeEncoder(std::size_t axis, std::uint64_t seed) const;
  double Advance(Utime at);
  void Happen(const Faults::Begun& begun);
  void HappenToDrive(std::size_t axis, const Faults::Begun& begun);
  void Note(double t_s, std::string_view what, std::string_view device, double value = 0.0);
  bool InputsPermit(std::size_t axis, double t_s, const MoveCommand& command) const;
  void Start(std::size_t axis, double t_s, const MoveCommand& command);

  std::mutex mutex_;
  const config::Scenario specimen_;
  const config::GyroUnitMap map_;
  const Utime start_;
  const std::array<AxisConstants, 3> constants_;
  double now_s_ = 0.0;
  Faults faults_;
  std::array<AxisMechanics, 3> axes_;
  std::array<AngleEncoder, 3> encoders_;
  std::array<int, 3> alarms_now_ = {};
  std::array<double, 3> encoder_slip_deg_ = {};  // by which a loose encoder has stayed behind
  std::array<std::int64_t, 3> count_zero_ = {};  // pulses at which a drive began to count
  std::array<DriveView, 3> last_view_ = {};
  std::array<std::uint32_t, 3> last_counts_ = {};
  GyroSampler gyro_;
  std::optional<TruthLog> truth_;
};

// Names of the stand's devices, as faults and messages call them.
inline constexpr std::array<const char*, 3> kAxisNames = {"outer", "middle", "inner"};
// Index of an axis of the stand file. Throws ConfigError for another name.
std::size_t AxisIndex(const std::string& name);

// From a scenario with spreads to one specimen: draws what differs from part to part
// (Scenario::drawn) and adds it to the values of the scenario. The result has no spread left. The
// same seed gives the same specimen; a spread of zero leaves the others' draws as they are.
config::Scenario DrawSpecimen(const config::Scenario& scenario, std::uint64_t seed);

}  // namespace gyrobench::stand
